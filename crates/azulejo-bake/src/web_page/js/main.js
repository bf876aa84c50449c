// The viewer: loads the model, draws when something changes, and offers a hook for programs.

class Model {
    static async load() {
        const model = new Model();
        const head = (model.head = JSON.parse(element("head").textContent));
        const numbers = (list) => list.map((_, k) => k);
        const [geometry, lightmaps, pictures] = await Promise.all([
            decodeGeometry(head),
            Promise.all(numbers(head.lightmaps).map((k) => decodeLightmap(head, k))),
            Promise.all(numbers(head.pictures).map((k) => decodePicture(head, k))),
        ]);
        Object.assign(model, { geometry, lightmaps, pictures });
        model.batches = makeBatches(head, geometry);
        model.bounds = boundsOf(geometry);
        model.diagonal = model.bounds.diagonal();
        model.hasErrors = head.lightmaps.some((map) => map.errorPeak !== null);
        model.cameras = [...head.cameras, framingCamera(model.bounds, head.up)];
        return model;
    }

    // Light in places of the surfaces, found when it is first asked for.
    get samples() {
        const { head, geometry, batches, lightmaps } = this;
        this.known ??= sampleLight(head, geometry, batches, lightmaps);
        return this.known;
    }

    // Values on the surfaces of what false colours show.
    values(show) {
        return this.samples.map((s) => (show === "error" ? (100 * s.error) / s.light : s.light));
    }
}

// The canvas's means to draw.
function contextOf(canvas) {
    const options = { antialias: true, alpha: false, powerPreference: "high-performance" };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) {
        throw new Error("This page needs WebGL 2, which this browser does not offer. " +
            "Perhaps it is switched off, or the graphics driver is too old.");
    }
    return gl;
}

class Viewer {
    constructor(model, canvas, program) {
        this.model = model;
        this.canvas = canvas;
        this.settings = {
            show: "lit", tone: "filmic", stops: 0, isAutomatic: true, isWalking: false,
            showTexels: false, hideBacks: false, range: [0, 1], isLogarithmic: false,
        };
        this.eye = new Eye(model);
        this.frames = 0;
        this.exposure = null;
        this.wanted = null;
        this.canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault();
            this.renderer = null;
            say("The graphics card was taken away; waiting for it…");
        });
        this.canvas.addEventListener("webglcontextrestored", () => this.begin());
        this.begin(program);
        this.navigation = new Navigation(canvas, this);
        this.interface = new Interface(this);
        this.canvas.addEventListener("pointermove", (event) => this.hovered(event));
        this.canvas.addEventListener("pointerleave", (event) => {
            if (event.pointerType === "mouse") {
                this.forget();
            }
        });
        this.resized();
        const observer = new ResizeObserver(() => this.resized());
        [canvas, element("dock")].forEach((part) => observer.observe(part));
        // Moving to a screen of another density changes no size in CSS pixels.
        window.addEventListener("resize", () => this.resized());
    }

    get isWalking() {
        return this.settings.isWalking;
    }

    // Makes what lives on the graphics card, at first and after it was lost.
    begin(program) {
        const gl = contextOf(this.canvas);
        this.renderer = new Renderer(gl, program ?? startProgram(gl), this.model);
        say("");
        this.requestDraw();
    }

    resized() {
        const ratio = Math.min(window.devicePixelRatio || 1, 3);
        const size = [this.canvas.clientWidth, this.canvas.clientHeight].map((s) => Math.max(1, Math.round(s * ratio)));
        if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) {
            [this.canvas.width, this.canvas.height] = size;
            this.changed(false);
        }
        const isFolded = document.body.classList.contains("folded");
        const covered = isFolded ? 0 : element("dock").offsetHeight / this.canvas.clientHeight;
        if (this.covered !== Math.min(covered, 0.45)) {
            this.covered = Math.min(covered, 0.45);
            this.changed(false);
        }
    }

    view() {
        return this.eye.view(this.canvas.width / this.canvas.height, this.covered);
    }

    // The point of view or what is drawn has changed.
    changed() {
        this.isExposureOld = true;
        element("readout").replaceChildren();
        this.mark(null);
        this.requestDraw();
    }

    requestDraw() {
        if (!this.isRequested) {
            this.isRequested = true;
            requestAnimationFrame((time) => this.frame(time));
        }
    }

    frame(time) {
        this.isRequested = false;
        if (!this.renderer) {
            return;
        }
        const seconds = clamp((time - (this.lastTime ?? time - 16)) / 1000, 0.001, 0.1);
        const isMoving = this.navigation.advance(seconds);
        this.isExposureOld ||= isMoving;
        const isAdapting = this.adapt(time, seconds);
        this.draw();
        if (this.hover && !this.navigation.isDragging && !isMoving) {
            this.readAt(...this.hover, true);
        }
        this.hover = null;
        // Time stands still while nothing moves.
        this.lastTime = isMoving || isAdapting ? time : null;
        if (isMoving || isAdapting) {
            this.requestDraw();
        }
    }

    draw() {
        const { settings, canvas } = this;
        this.renderer.gl.bindFramebuffer(this.renderer.gl.FRAMEBUFFER, null);
        const look = {
            ...settings,
            show: SHOW[settings.show],
            exposure: (this.exposure ?? 1) * 2 ** settings.stops,
        };
        this.renderer.draw(this.view(), look, canvas.width, canvas.height);
        this.frames++;
    }

    // Brings the exposure nearer to what the view asks for; whether there is more to do.
    adapt(time, seconds) {
        const { settings } = this;
        const isAsked = settings.isAutomatic || this.exposure === null;
        if (!isAsked || settings.show !== "lit") {
            return false;
        }
        const isDue = this.isExposureOld && !(time - this.measured < 200);
        if (isDue) {
            this.wanted = exposureOfView(this.renderer, this.view(), this.model, settings.hideBacks);
            this.measured = time;
            this.isExposureOld = false;
        }
        const way = this.exposure === null ? 0 : Math.log(this.wanted / this.exposure);
        if (this.exposure === null || Math.abs(way) < 0.01 || isStill()) {
            this.exposure = this.wanted;
            return this.isExposureOld;
        }
        this.exposure *= Math.exp(way * (1 - Math.exp(-seconds * 8)));
        return true;
    }

    hovered(event) {
        if (event.pointerType === "mouse" && !this.navigation.isDragging) {
            this.hover = this.navigation.share(event);
            this.requestDraw();
        }
    }

    tapped(event) {
        this.readAt(...this.navigation.share(event), event.pointerType === "mouse");
    }

    pickAt(x, y) {
        return this.renderer && this.renderer.pick(this.view(), x, y, this.settings);
    }

    // Shows the values at a place of the picture, 0 to 1; a mark says where, unless the pointer does.
    readAt(x, y, isPointed) {
        const hit = this.pickAt(x, y);
        element("readout").replaceChildren(...(hit ? readoutOf(hit, this.model.head) : []));
        this.mark(hit && !isPointed ? [x, y] : null);
        return hit;
    }

    mark(place) {
        const mark = element("mark");
        mark.hidden = !place;
        if (place) {
            mark.style.left = `${100 * place[0]}%`;
            mark.style.top = `${100 * place[1]}%`;
        }
    }

    forget() {
        this.hover = null;
        element("readout").replaceChildren();
        this.mark(null);
    }

    useCamera(number) {
        const camera = this.model.cameras[number];
        if (camera) {
            element("camera").value = String(number);
            this.eye.set(camera);
            this.exposure = this.settings.isAutomatic ? null : this.exposure;
            this.changed();
        }
    }

    // Goes halfway to a place and turns about it from now on.
    goTo(position) {
        const { eye } = this;
        const from = { pivot: eye.pivot(), distance: eye.distance, place: eye.place };
        const { forward } = eye.frame();
        eye.isPivotKnown = true;
        eye.distance = Math.max(length(subtract(position, eye.place)) / 2, 1e-3 * this.model.diagonal);
        const goal = subtract(position, times(forward, eye.distance));
        const start = performance.now();
        const step = () => {
            const t = isStill() ? 1 : clamp((performance.now() - start) / 250, 0, 1);
            const eased = t * t * (3 - 2 * t);
            eye.place = add(times(from.place, 1 - eased), times(goal, eased));
            this.changed();
            if (t < 1 && !this.navigation.isDragging) {
                requestAnimationFrame(step);
            }
        };
        step();
    }
}

// Whether the reader asked for no motion that nobody steers.
const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

function say(text, isFailure) {
    const message = element("message");
    message.textContent = text;
    message.hidden = !text;
    message.classList.toggle("failure", Boolean(isFailure));
}

// A camera of the file by its number, or one given as { eye, target, up, verticalFov }, degrees.
function viewOf(model, camera, aspect) {
    const given = typeof camera === "object" ? camera : model.cameras[camera ?? 0];
    const eye = new Eye({ ...model, cameras: [{ up: model.head.up, ...given }] });
    const tangent = Math.tan(eye.fov / 2);
    return { eye: eye.place, frame: eye.frame(), tangents: [tangent * aspect, tangent] };
}

// The hook for programs, `window.azulejo`:
//   ready          a promise: fulfilled when the first picture is drawn, rejected if it cannot be
//   frames         how many pictures have been drawn
//   head           the head of the data
//   render({ camera, width, height, quantity })
//                  numbers of a picture: a Float32Array, four per pixel, rows from the top. `camera` is a number or
//                  { eye, target, up, verticalFov } with degrees. `quantity` is "radiance" (the default),
//                  RGB and coverage, or "light": RGB of E, and luminance of its standard error.
//   pick(x, y)     what is at a place of the view, 0 to 1 from the upper left
//   place()        where the eye is
//   set(settings)  as the controls do: show ("lit", "plain", "light", "error"), tone, stops, camera, …
function offerHook(ready) {
    const hook = (window.azulejo = { ready });
    ready.then((viewer) => {
        Object.defineProperty(hook, "frames", { get: () => viewer.frames });
        hook.head = viewer.model.head;
        hook.render = ({ camera, width = 256, height = 256, quantity = "radiance" }) => {
            const look = { show: quantity === "light" ? SHOW.values : SHOW.radiance };
            return viewer.renderer.read(viewOf(viewer.model, camera, width / height), look, width, height);
        };
        hook.pick = (x, y) => viewer.pickAt(x, y);
        hook.place = () => [...viewer.eye.place];
        hook.set = ({ show, camera, ...settings }) => {
            Object.assign(viewer.settings, settings);
            if (camera !== undefined) {
                viewer.useCamera(camera);
            }
            if (show !== undefined) {
                viewer.interface.choose(show);
            }
            viewer.changed();
        };
    }, () => {});
}

async function start() {
    if (!window.DecompressionStream) {
        throw new Error("This page needs a browser of 2023 or later.");
    }
    // The graphics card gets ready while the data are unpacked.
    const canvas = element("picture");
    const program = startProgram(contextOf(canvas));
    const viewer = new Viewer(await Model.load(), canvas, program);
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    return viewer;
}

const started = start();
started.catch((problem) => {
    console.error(problem);
    say(problem.message, true);
    document.body.classList.add("failed");
});
offerHook(started);
