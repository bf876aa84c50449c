// The controls: they change `viewer.settings` and say so.

const KEYS = {
    KeyL: (ui) => ui.choose(ui.settings.show === "lit" ? "plain" : "lit"),
    KeyF: (ui) => ui.choose(ui.settings.show === "light" ? "lit" : "light"),
    KeyX: (ui) => ui.choose(ui.settings.show === "error" ? "lit" : "error"),
    KeyT: (ui) => ui.toggle("texels"),
    KeyB: (ui) => ui.toggle("hide-backs"),
    KeyO: (ui) => ui.toggle("walking"),
    KeyR: (ui) => ui.viewer.useCamera(Number(element("camera").value) || 0),
    KeyV: (ui) => ui.fullscreen(),
    KeyC: (ui) => ui.fold(),
    KeyH: (ui) => ui.help(),
    Digit0: (ui) => ui.exposeAutomatically(),
};

class Interface {
    constructor(viewer) {
        this.viewer = viewer;
        this.settings = viewer.settings;
        const { head } = viewer.model;
        element("title").textContent = head.title;
        element("note").textContent = head.note;
        this.offer("light-choice", head.lightmaps.length > 0, "The file has no light");
        this.offer("error-choice", viewer.model.hasErrors, "The file has no standard errors");
        this.fillCameras();
        this.stateFacts();
        this.listen();
        this.range = { light: null, error: null };
        this.isLogarithmic = { light: null, error: null };
        this.choose(head.lightmaps.length > 0 ? "lit" : "plain");
    }

    // Takes a choice away for a reason.
    offer(id, isOffered, reason) {
        if (!isOffered) {
            element(id).querySelector("input").disabled = true;
            element(id).title = reason;
        }
    }

    fillCameras() {
        const { cameras } = this.viewer.model;
        const options = cameras.map((camera, k) => {
            const option = document.createElement("option");
            option.value = String(k);
            option.textContent = camera.name || `Camera ${k + 1}`;
            return option;
        });
        element("camera").replaceChildren(...options);
    }

    stateFacts() {
        const { head, geometry } = this.viewer.model;
        const count = (n, one, many) => `${n.toLocaleString("en")} ${n === 1 ? one : many}`;
        const maps = head.lightmaps.map((map) => `${map.width} × ${map.height}`).join(", ");
        element("facts").textContent = [
            count(geometry.indices.length / 3, "triangle", "triangles"),
            count(head.meshes.length, "surface", "surfaces"),
            maps ? `texels of light: ${maps}` : "no light",
        ].join(" · ");
    }

    listen() {
        const { settings, viewer } = this;
        const on = (id, name, handler) => element(id).addEventListener(name, handler);
        element("controls").addEventListener("submit", (event) => event.preventDefault());
        on("shows", "change", (event) => this.choose(event.target.value));
        on("stops", "input", (event) => this.setStops(Number(event.target.value)));
        on("auto", "change", (event) => {
            settings.isAutomatic = event.target.checked;
            viewer.changed(false);
        });
        on("tone", "change", (event) => {
            settings.tone = event.target.value;
            viewer.requestDraw();
        });
        on("camera", "change", (event) => viewer.useCamera(Number(event.target.value)));
        const boxes = { walking: "isWalking", texels: "showTexels", "hide-backs": "hideBacks" };
        for (const [id, setting] of Object.entries(boxes)) {
            on(id, "change", (event) => {
                settings[setting] = event.target.checked;
                viewer.changed(false);
            });
        }
        on("logarithmic", "change", (event) => {
            this.isLogarithmic[settings.show] = event.target.checked;
            this.fit(settings.show);
            this.shownChanged();
        });
        on("fit", "click", () => {
            this.fit(settings.show);
            this.shownChanged();
        });
        ["low", "high"].forEach((id) => on(id, "change", () => this.rangeTyped()));
        on("full", "click", () => this.fullscreen());
        on("help-button", "click", () => this.help());
        // A form of the dialog would close it, too, but frames may forbid forms.
        on("help-close", "click", () => element("help").close());
        on("fold", "click", () => this.fold());
        element("full").hidden = !document.fullscreenEnabled;
        window.addEventListener("keydown", (event) => this.keyPressed(event));
    }

    keyPressed(event) {
        const inDialog = event.target.closest && event.target.closest("dialog, select, input[type=text]");
        if (inDialog || event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        const digit = /^Digit([1-9])$/.exec(event.code);
        if (event.key === "+" || event.key === "-") {
            this.setStops(this.settings.stops + (event.key === "+" ? 0.5 : -0.5));
        } else if (event.key === "?") {
            this.help();
        } else if (event.key === "Enter" && event.target === this.viewer.canvas) {
            this.viewer.readAt(0.5, 0.5);
        } else if (event.key === "Escape") {
            this.viewer.forget();
        } else if (digit) {
            this.viewer.useCamera(Number(digit[1]) - 1);
        } else if (KEYS[event.code] && !event.repeat) {
            KEYS[event.code](this);
        }
    }

    choose(show) {
        const choice = document.querySelector(`input[name="show"][value="${show}"]`);
        if (choice.disabled) {
            return;
        }
        this.settings.show = show;
        choice.checked = true;
        this.shownChanged();
    }

    toggle(id) {
        element(id).click();
    }

    setStops(stops) {
        this.settings.stops = clamp(stops, -6, 6);
        element("stops").value = this.settings.stops;
        element("stops-shown").textContent = `${stops > 0 ? "+" : ""}${Number(this.settings.stops.toFixed(1))}`;
        this.viewer.requestDraw();
    }

    exposeAutomatically() {
        this.setStops(0);
        element("auto").checked = this.settings.isAutomatic = true;
        this.viewer.changed(false);
    }

    // Sets the range of a kind of value to what the model has; logarithmic at first if that is wide.
    fit(show) {
        if (this.isLogarithmic[show] === null) {
            const [low, high] = rangeOf(this.viewer.model.values(show), true);
            this.isLogarithmic[show] = high / low > 30;
        }
        this.range[show] = rangeOf(this.viewer.model.values(show), this.isLogarithmic[show]);
    }

    rangeTyped() {
        const [low, high] = ["low", "high"].map((id) => Number(element(id).value.replace(",", ".")));
        const isLogarithmic = this.isLogarithmic[this.settings.show];
        const isRange = Number.isFinite(low) && Number.isFinite(high) && low < high &&
            (isLogarithmic ? low > 0 : low >= 0);
        ["low", "high"].forEach((id) => element(id).setAttribute("aria-invalid", String(!isRange)));
        if (isRange) {
            this.range[this.settings.show] = [low, high];
            this.shownChanged();
        }
    }

    // Brings the legend up to date with what is shown.
    shownChanged() {
        const { settings, viewer } = this;
        const { show } = settings;
        const hasScale = show === "light" || show === "error";
        element("legend").hidden = !hasScale;
        element("exposure-row").disabled = show !== "lit";
        if (hasScale) {
            const { photometric } = viewer.model.head;
            const [name, unit] = show === "error" ? ["Error", "% of value"]
                : photometric ? ["Illuminance", "lux"] : ["Irradiance", "W/m²"];
            element("quantity").replaceChildren(name, Object.assign(document.createElement("small"),
                { textContent: unit }));
            if (!this.range[show]) {
                this.fit(show);
            }
            settings.range = this.range[show];
            settings.isLogarithmic = this.isLogarithmic[show];
            element("logarithmic").checked = settings.isLogarithmic;
            ["low", "high"].forEach((id, k) => {
                element(id).value = Number(settings.range[k].toPrecision(4));
                element(id).setAttribute("aria-invalid", "false");
            });
            drawLegend(document.querySelector(".scale"), settings.range, settings.isLogarithmic);
        }
        viewer.requestDraw();
    }

    fullscreen() {
        if (document.fullscreenElement) {
            document.exitFullscreen();
        } else if (document.fullscreenEnabled) {
            document.documentElement.requestFullscreen().catch(() => {});
        }
    }

    fold() {
        const isFolded = document.body.classList.toggle("folded");
        element("fold").setAttribute("aria-expanded", String(!isFolded));
        this.viewer.resized();
    }

    help() {
        element("help").showModal();
    }
}

// What is at a place, in words.
function readoutOf(hit, head) {
    const [unitOfLight, unitOfRadiance] = head.photometric ? ["lux", "cd/m²"] : ["W/m²", "W/(sr·m²)"];
    const words = (text, name) => Object.assign(document.createElement(name), { textContent: text });
    const mesh = head.meshes[hit.mesh];
    const parts = [];
    if (hit.isLit) {
        parts.push(words(`${shown(hit.light)} ${unitOfLight}`, "b"));
        if (hit.error > 0 && hit.light > 0) {
            parts.push(` ± ${shown((100 * hit.error) / hit.light)}%`);
        }
        parts.push(" · ");
    }
    parts.push(`${shown(hit.radiance)} ${unitOfRadiance}`);
    if (mesh && mesh.name) {
        const name = words(mesh.name, "span");
        name.className = "name";
        parts.push(" · ", name);
    }
    return parts;
}

