// The eye: where it is, where it looks, and how pointers and keys move it.

const STRAIGHT = Math.PI / 2;

// A point of view as angles. Yaw turns to the right about the axis that points up, pitch upwards.
class Eye {
    constructor(model) {
        this.model = model;
        this.up = model.head.up;
        const sideways = [1, 0, 0];
        this.axes = { sideways, ahead: cross(this.up, sideways) };
        this.set(model.cameras[0]);
    }

    // Takes the place, direction and angle of a camera.
    set(camera) {
        const { up, axes } = this;
        const forward = normalize(subtract(camera.target, camera.eye));
        const isSteep = Math.abs(dot(forward, up)) > 0.9999;
        // Looking straight down, what is up in the picture says where the eye would look.
        const heading = isSteep ? times(camera.up, -Math.sign(dot(forward, up))) : forward;
        this.place = [...camera.eye];
        this.yaw = Math.atan2(dot(heading, axes.sideways), dot(heading, axes.ahead));
        this.pitch = Math.asin(clamp(dot(forward, up), -1, 1));
        this.roll = 0;
        const level = this.frame();
        const upright = subtract(camera.up, times(forward, dot(camera.up, forward)));
        this.roll = Math.atan2(dot(upright, level.right), dot(upright, level.up));
        this.fov = (camera.verticalFov * Math.PI) / 180;
        this.aspect = camera.size ? camera.size[0] / camera.size[1] : 1;
        this.distance = length(subtract(camera.target, camera.eye));
        this.isPivotKnown = Boolean(camera.isFraming);
    }

    frame() {
        const { yaw, pitch, roll, up, axes } = this;
        const level = add(times(axes.ahead, Math.cos(yaw)), times(axes.sideways, Math.sin(yaw)));
        const flatRight = subtract(times(axes.sideways, Math.cos(yaw)), times(axes.ahead, Math.sin(yaw)));
        const forward = add(times(level, Math.cos(pitch)), times(up, Math.sin(pitch)));
        const flatUp = cross(flatRight, forward);
        const right = subtract(times(flatRight, Math.cos(roll)), times(flatUp, Math.sin(roll)));
        return { right, up: cross(right, forward), forward };
    }

    // The view in a picture of this shape, width over height, of whose height a share at the bottom is
    // covered by controls. What a camera shows in its own picture stays in view in narrower ones.
    view(aspect, covered = 0) {
        const free = 1 - covered;
        const widening = Math.max(1, (Math.min(this.aspect, 4 / 3) * free) / aspect);
        const tangent = (Math.tan(this.fov / 2) * widening) / free;
        const tangents = [tangent * aspect, tangent];
        return { eye: this.place, frame: this.frame(), tangents, lift: covered };
    }

    pivot() {
        return add(this.place, times(this.frame().forward, this.distance));
    }

    // Turns about the pivot; angles in radians.
    orbit(yaw, pitch) {
        const pivot = this.pivot();
        this.turn(yaw, pitch);
        this.place = subtract(pivot, times(this.frame().forward, this.distance));
    }

    // Turns on the spot.
    turn(yaw, pitch) {
        this.roll = 0;
        this.yaw += yaw;
        this.pitch = clamp(this.pitch + pitch, -STRAIGHT, STRAIGHT);
    }

    move(by) {
        this.place = add(this.place, by);
    }

    // Comes nearer to the pivot, or goes away from it, by a factor of the distance; near it, pushes it ahead.
    approach(factor) {
        const least = 0.01 * this.model.diagonal;
        const pivot = this.pivot();
        const { forward } = this.frame();
        this.move(times(forward, this.distance * (1 - factor)));
        const distance = dot(subtract(pivot, this.place), forward);
        this.distance = clamp(distance, Math.min(least, this.distance), 20 * this.model.diagonal);
    }
}

// A camera from which all of a box is in view, from the front and a little above.
function framingCamera(box, up) {
    const verticalFov = 40;
    const tangent = Math.tan((verticalFov * Math.PI) / 360);
    const centre = box.centre();
    const forward = normalize(times(up[1] > 0.5 ? [0.5, 0.35, 1] : [0.5, -1, 0.35], -1));
    const right = normalize(cross(forward, up));
    const upright = cross(right, forward);
    // Each corner asks for a distance from the centre at which it is just in view.
    const distances = box.corners().map((place) => {
        const from = subtract(place, centre);
        const beside = Math.max(Math.abs(dot(from, right)), Math.abs(dot(from, upright)));
        return beside / tangent - dot(from, forward);
    });
    const distance = 1.06 * Math.max(...distances, 1e-6);
    return {
        name: "Everything",
        eye: subtract(centre, times(forward, distance)),
        target: centre,
        up,
        verticalFov,
        size: null,
        isFraming: true,
    };
}

const STEPS = {
    KeyW: [0, 0, 1], ArrowUp: [0, 0, 1], KeyS: [0, 0, -1], ArrowDown: [0, 0, -1],
    KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], PageUp: [0, 1, 0], KeyQ: [0, -1, 0],
    PageDown: [0, -1, 0],
};
const TURNS = { ArrowLeft: -1, ArrowRight: 1 };

// Whether another page is around this one, as a notebook: the wheel scrolls that until the model is clicked.
const isFramed = window.parent !== window;

// Pointers and keys on a canvas. `viewer` has eye, model, isWalking, pickAt(x, y) and changed(isMoving).
class Navigation {
    constructor(canvas, viewer) {
        this.canvas = canvas;
        this.viewer = viewer;
        document.documentElement.classList.toggle("framed", isFramed);
        this.pointers = new Map();
        this.held = new Set();
        this.travelled = 0;
        const on = (name, handler, options) => canvas.addEventListener(name, handler.bind(this), options);
        on("pointerdown", this.pressed);
        on("pointermove", this.moved);
        on("pointerup", this.released);
        on("pointercancel", this.released);
        on("wheel", this.rolled, { passive: false });
        on("dblclick", this.clickedTwice);
        canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        window.addEventListener("keydown", (event) => this.keyPressed(event));
        window.addEventListener("keyup", (event) => {
            this.held.delete(event.code);
            this.isFast = event.shiftKey;
        });
        window.addEventListener("blur", () => this.held.clear());
    }

    get isDragging() {
        return this.pointers.size > 0;
    }

    pressed(event) {
        this.canvas.focus({ preventScroll: true });
        this.canvas.setPointerCapture(event.pointerId);
        this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
        this.travelled = this.pointers.size > 1 ? Infinity : 0;
        this.findPivot();
    }

    // The first time something turns about a pivot, that is what is in the middle of the picture.
    findPivot() {
        const { eye, model } = this.viewer;
        if (eye.isPivotKnown) {
            return;
        }
        eye.isPivotKnown = true;
        const hit = this.viewer.pickAt(0.5, 0.5);
        const centre = dot(subtract(model.bounds.centre(), eye.place), eye.frame().forward);
        eye.distance = Math.max(hit ? hit.distance : centre, 0.02 * model.diagonal);
        // A room is turned about its middle, not about its far wall.
        if (hit && centre > 0.1 * hit.distance && centre < hit.distance) {
            eye.distance = centre;
        }
    }

    moved(event) {
        const last = this.pointers.get(event.pointerId);
        if (!last) {
            return;
        }
        const now = { x: event.clientX, y: event.clientY };
        const [dx, dy] = [now.x - last.x, now.y - last.y];
        this.travelled += Math.hypot(dx, dy);
        if (this.pointers.size === 1) {
            const isPanning = event.shiftKey || (event.buttons & 6) !== 0;
            isPanning ? this.pan(dx, dy) : this.rotate(dx, dy);
        } else if (this.pointers.size === 2) {
            const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
            this.pinch(other, last, now);
        }
        this.pointers.set(event.pointerId, now);
        this.viewer.changed(true);
    }

    rotate(dx, dy) {
        const { eye, isWalking } = this.viewer;
        if (isWalking) {
            const perPixel = (2 * eye.view(1).tangents[1]) / this.canvas.clientHeight;
            eye.turn(-dx * perPixel, dy * perPixel);
        } else {
            eye.orbit(dx * 0.006, -dy * 0.006);
        }
    }

    pan(dx, dy) {
        const { eye } = this.viewer;
        const { right, up } = eye.frame();
        const { clientWidth, clientHeight } = this.canvas;
        const size = 2 * eye.distance * eye.view(clientWidth / clientHeight).tangents[1];
        eye.move(add(times(right, (-dx * size) / clientHeight), times(up, (dy * size) / clientHeight)));
    }

    // Two fingers: their distance zooms, their middle pans.
    pinch(other, last, now) {
        const { eye, isWalking, model } = this.viewer;
        const before = Math.hypot(last.x - other.x, last.y - other.y);
        const after = Math.hypot(now.x - other.x, now.y - other.y);
        const factor = clamp(before / Math.max(after, 1), 0.5, 2);
        if (isWalking) {
            eye.move(times(eye.frame().forward, (1 - factor) * 0.3 * model.diagonal));
        } else {
            eye.approach(factor);
        }
        this.pan((now.x - last.x) / 2, (now.y - last.y) / 2);
    }

    released(event) {
        const isTap = this.pointers.size === 1 && this.travelled < 6;
        this.pointers.delete(event.pointerId);
        this.viewer.changed(false);
        if (isTap && event.type === "pointerup") {
            this.viewer.tapped(event);
        }
    }

    rolled(event) {
        if (isFramed && !document.hasFocus()) {
            return;
        }
        event.preventDefault();
        this.findPivot();
        const { eye, isWalking, model } = this.viewer;
        const lines = event.deltaMode === 1 ? 30 : event.deltaMode === 2 ? 300 : 1;
        const amount = clamp(event.deltaY * lines, -300, 300);
        if (isWalking) {
            eye.move(times(eye.frame().forward, (-amount / 3000) * model.diagonal));
        } else {
            eye.approach(Math.exp(amount * 0.0015));
        }
        this.viewer.changed(true);
    }

    // Goes halfway to a place and turns about it from now on.
    clickedTwice(event) {
        const hit = this.viewer.pickAt(...this.share(event));
        if (hit) {
            this.viewer.goTo(hit.position);
        }
    }

    // The place of an event in the picture, 0 to 1.
    share(event) {
        const box = this.canvas.getBoundingClientRect();
        return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    }

    keyPressed(event) {
        const isWithin = (places) => Boolean(event.target.closest && event.target.closest(places));
        // Letters mean nothing to boxes and sliders, but arrows do.
        const isTaken = isWithin("select, textarea, dialog, input[type=text]") ||
            (isWithin("input") && /^(Arrow|Page)/.test(event.code));
        this.isFast = event.shiftKey;
        if (isTaken || event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        if (event.code in STEPS || event.code in TURNS) {
            event.preventDefault();
            this.findPivot();
            this.held.add(event.code);
            this.viewer.changed(true);
        }
    }

    // Moves as the held keys say; whether any is held.
    advance(seconds) {
        if (this.held.size === 0) {
            return false;
        }
        const { eye, model, isWalking } = this.viewer;
        const { right, forward } = eye.frame();
        const { up } = eye;
        // Walking stays level, flying goes where the eye looks.
        const level = cross(up, right);
        const ahead = isWalking ? level : forward;
        const way = 0.12 * model.diagonal * seconds * (this.isFast ? 4 : 1);
        for (const code of this.held) {
            const step = STEPS[code];
            if (step) {
                const direction = add(add(times(right, step[0]), times(up, step[1])), times(ahead, step[2]));
                eye.move(times(direction, way));
            } else {
                eye.turn(TURNS[code] * seconds * 1.2, 0);
            }
        }
        return true;
    }
}

