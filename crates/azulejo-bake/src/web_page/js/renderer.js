// Drawing with WebGL 2.

// What the shader shows.
const SHOW = { lit: 0, plain: 1, light: 2, error: 3, radiance: 4, values: 5, places: 6 };
const TONES = { linear: 0, filmic: 1, soft: 2 };

// Viridis by Smith and van der Walt, 2015, CC0: every fifteenth of its 256 colours.
const VIRIDIS = ("440154 481567 482677 453781 404788 39568c 33638d 2d708e 287d8e 238a8d 1f968b 20a387 " +
    "29af7f 3cbb75 55c667 73d055 95d840 b8de29 dce319 fde725").split(" ").map((hex) =>
    [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));

// The colour of t, 0 to 1, as bytes.
function rampColor(t) {
    const place = clamp(t, 0, 1) * (VIRIDIS.length - 1);
    const k = Math.min(Math.floor(place), VIRIDIS.length - 2);
    return VIRIDIS[k].map((low, c) => Math.round(low + (place - k) * (VIRIDIS[k + 1][c] - low)));
}

class Renderer {
    constructor(gl, program, model) {
        this.gl = gl;
        this.model = model;
        this.canFloat = Boolean(gl.getExtension("EXT_color_buffer_float"));
        this.canHalf = this.canFloat || Boolean(gl.getExtension("EXT_color_buffer_half_float"));
        this.canBlendFloat = Boolean(gl.getExtension("EXT_float_blend"));
        this.program = program;
        checkProgram(gl, program);
        this.uniforms = uniformsOf(gl, program);
        this.shape = this.makeShape(model.geometry);
        this.white = this.makeTexture(1, 1, new Uint8Array([255, 255, 255, 255]));
        const ramp = Array.from({ length: 256 }, (_, k) => [...rampColor(k / 255), 255]).flat();
        this.ramp = this.makeTexture(256, 1, new Uint8Array(ramp));
        this.lightmaps = model.lightmaps.map((map) => this.makeLightmap(map));
        this.pictures = model.pictures.map((image, k) => this.makePicture(image, model.head.pictures[k]));
        this.targets = new Map();
    }

    makeShape(geometry) {
        const { gl } = this;
        const shape = gl.createVertexArray();
        gl.bindVertexArray(shape);
        const attribute = (place, data, size, type, normalized, stride) => {
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
            gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
            gl.enableVertexAttribArray(place);
            gl.vertexAttribPointer(place, size, type, normalized, stride, 0);
        };
        attribute(0, geometry.positions, 3, gl.FLOAT, false, 12);
        attribute(1, geometry.normals, 3, gl.BYTE, true, 4);
        attribute(2, geometry.uvs, 2, gl.FLOAT, false, 8);
        attribute(3, geometry.lightUvs, 2, gl.FLOAT, false, 8);
        attribute(4, geometry.colors, 3, gl.UNSIGNED_SHORT, true, 8);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, geometry.indices, gl.STATIC_DRAW);
        gl.bindVertexArray(null);
        return shape;
    }

    boundTexture(filter, wrap) {
        const { gl } = this;
        const texture = gl.createTexture();
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
        gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrap[0]);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, wrap[1]);
        return texture;
    }

    makeTexture(width, height, bytes) {
        const { gl } = this;
        const texture = this.boundTexture(gl.LINEAR, [gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE]);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
        return texture;
    }

    makeLightmap(map) {
        const { gl } = this;
        const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
        if (Math.max(map.width, map.height) > most) {
            throw new Error(`the lightmap has ${map.width} × ${map.height} texels; ` +
                `this graphics card takes ${most} a side`);
        }
        const texture = this.boundTexture(gl.LINEAR, [gl.CLAMP_TO_EDGE, gl.CLAMP_TO_EDGE]);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, map.width, map.height, 0, gl.RGBA, gl.HALF_FLOAT,
            map.texels);
        return texture;
    }

    makePicture(image, { wrap }) {
        if (!image) {
            return this.white;
        }
        const { gl } = this;
        const modes = { repeat: gl.REPEAT, clamp: gl.CLAMP_TO_EDGE, mirror: gl.MIRRORED_REPEAT };
        const texture = this.boundTexture(gl.LINEAR_MIPMAP_LINEAR, wrap.map((name) => modes[name]));
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
        gl.generateMipmap(gl.TEXTURE_2D);
        const fine = gl.getExtension("EXT_texture_filter_anisotropic");
        if (fine) {
            const most = gl.getParameter(fine.MAX_TEXTURE_MAX_ANISOTROPY_EXT);
            gl.texParameterf(gl.TEXTURE_2D, fine.TEXTURE_MAX_ANISOTROPY_EXT, Math.min(8, most));
        }
        return texture;
    }

    // Draws what `look` says into the bound framebuffer. `view` has eye, frame and tangents.
    draw(view, look, width, height) {
        const { gl, uniforms, model } = this;
        const isData = look.show >= SHOW.radiance;
        gl.viewport(0, 0, width, height);
        gl.disable(gl.SCISSOR_TEST);
        gl.depthMask(true);
        gl.clearColor(...(isData ? [0, 0, 0, 0] : [0.062, 0.067, 0.078, 1]));
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        gl.enable(gl.DEPTH_TEST);
        gl.useProgram(this.program);
        gl.bindVertexArray(this.shape);
        const [near, far] = this.depths(view);
        const matrix = viewProjection(view, near, far);
        gl.uniformMatrix4fv(uniforms.viewProjection, false, matrix);
        gl.uniform3fv(uniforms.eye, view.eye);
        gl.uniform1i(uniforms.picture, 0);
        gl.uniform1i(uniforms.light, 1);
        gl.uniform1i(uniforms.ramp, 2);
        gl.uniform1i(uniforms.show, look.show);
        gl.uniform1f(uniforms.exposure, look.exposure ?? 1);
        gl.uniform1i(uniforms.tone, TONES[look.tone] ?? 0);
        gl.uniform2fv(uniforms.range, look.range ?? [0, 1]);
        gl.uniform1i(uniforms.isLogarithmic, look.isLogarithmic ? 1 : 0);
        gl.uniform1i(uniforms.showTexels, look.showTexels ? 1 : 0);
        this.bind(2, this.ramp);
        const isBlended = (batch) => model.head.materials[batch.material].mode === "blend";
        gl.disable(gl.BLEND);
        for (const batch of model.batches.filter((b) => !isBlended(b))) {
            this.drawBatch(batch, look, [batch]);
        }
        if (isData && look.show !== SHOW.radiance) {
            // What is half transparent has values like anything else.
            model.batches.filter(isBlended).forEach((batch) => this.drawBatch(batch, look, [batch]));
        } else {
            this.drawBlended(model.batches.filter(isBlended), view, look);
        }
        gl.depthMask(true);
    }

    // Draws half transparent parts from back to front.
    drawBlended(batches, view, look) {
        const { gl } = this;
        const parts = batches.flatMap((batch) => batch.parts.map((part) => ({ batch, part })));
        const distance = ({ part }) => length(subtract(part.centre, view.eye));
        parts.sort((a, b) => distance(b) - distance(a));
        gl.enable(gl.BLEND);
        gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
        gl.depthMask(false);
        parts.forEach(({ batch, part }) => this.drawBatch(batch, look, [part]));
        gl.disable(gl.BLEND);
    }

    // Sets material and light of a batch and draws ranges of it.
    drawBatch(batch, look, ranges) {
        const { gl, uniforms, model } = this;
        const material = model.head.materials[batch.material];
        const isLit = batch.lightmap >= 0;
        this.bind(0, material.picture === null ? this.white : this.pictures[material.picture]);
        this.bind(1, isLit ? this.lightmaps[batch.lightmap] : this.white);
        const map = isLit ? model.lightmaps[batch.lightmap] : { scale: 0, errorScale: 0 };
        gl.uniform2f(uniforms.lightScale, map.scale, map.errorScale);
        gl.uniform1i(uniforms.isLit, isLit ? 1 : 0);
        gl.uniform3fv(uniforms.baseColor, material.baseColor);
        gl.uniform3fv(uniforms.emission, material.emission);
        gl.uniform1f(uniforms.cutoff, material.mode === "mask" ? material.opacity : -1);
        gl.uniform1f(uniforms.opacity, material.mode === "blend" ? material.opacity : -1);
        gl.uniform1i(uniforms.isUnlit, material.unlit ? 1 : 0);
        if (material.doubleSided && !look.hideBacks) {
            gl.disable(gl.CULL_FACE);
        } else {
            gl.enable(gl.CULL_FACE);
        }
        const isNumbered = look.show === SHOW.places;
        for (const range of isNumbered ? batch.parts : ranges) {
            gl.uniform1f(uniforms.meshNumber, range.number ?? 0);
            gl.drawElements(gl.TRIANGLES, range.count, gl.UNSIGNED_INT, 4 * range.first);
        }
    }

    bind(unit, texture) {
        const { gl } = this;
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
    }

    // Distances between which all that is in view lies.
    depths(view) {
        const ahead = this.model.bounds.corners().map((c) => dot(subtract(c, view.eye), view.frame.forward));
        const far = Math.max(Math.max(...ahead) * 1.01, 1e-3 * this.model.diagonal);
        const near = Math.max(Math.min(...ahead) * 0.99, 2e-4 * Math.min(far, this.model.diagonal));
        return [near, far];
    }

    // Numbers of a picture, four per pixel, rows from the top; null where this browser cannot.
    read(view, look, width, height) {
        if (!this.canHalf) {
            return null;
        }
        const { gl } = this;
        const isBlended = look.show === SHOW.radiance;
        this.bindTarget(width, height, this.canFloat && (this.canBlendFloat || !isBlended));
        this.draw(view, look, width, height);
        const rows = new Float32Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, rows);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        const turned = new Float32Array(rows.length);
        for (let y = 0; y < height; y++) {
            turned.set(rows.subarray(4 * width * y, 4 * width * (y + 1)), 4 * width * (height - 1 - y));
        }
        return turned;
    }

    // Binds a framebuffer of floats, or half floats, with this size; the last few are kept.
    bindTarget(width, height, isWhole) {
        const { gl } = this;
        const key = `${width}x${height} ${isWhole}`;
        if (this.targets.has(key)) {
            gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets.get(key).buffer);
            return;
        }
        const made = { buffer: gl.createFramebuffer(), parts: [] };
        gl.bindFramebuffer(gl.FRAMEBUFFER, made.buffer);
        const attach = (format, place) => {
            const part = gl.createRenderbuffer();
            gl.bindRenderbuffer(gl.RENDERBUFFER, part);
            gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, part);
            made.parts.push(part);
        };
        attach(isWhole ? gl.RGBA32F : gl.RGBA16F, gl.COLOR_ATTACHMENT0);
        attach(gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT);
        this.targets.set(key, made);
        if (this.targets.size > 4) {
            const [oldest, old] = this.targets.entries().next().value;
            old.parts.forEach((part) => gl.deleteRenderbuffer(part));
            gl.deleteFramebuffer(old.buffer);
            this.targets.delete(oldest);
        }
    }

    // What is at a place of the picture, x and y in 0 to 1 from the upper left; null if nothing is.
    pick(view, x, y, look) {
        const { right, up, forward } = view.frame;
        const across = times(right, (2 * x - 1) * view.tangents[0]);
        const upwards = times(up, (1 - 2 * y - (view.lift ?? 0)) * view.tangents[1]);
        const direction = normalize(add(forward, add(across, upwards)));
        const side = normalize(cross(direction, up));
        const frame = { right: side, up: cross(side, direction), forward: direction };
        const narrow = { eye: view.eye, frame, tangents: [1e-4, 1e-4] };
        const hideBacks = look.hideBacks;
        const place = this.read(narrow, { show: SHOW.places, hideBacks }, 1, 1);
        if (!place || place[3] < 0.5) {
            return null;
        }
        const value = this.read(narrow, { show: SHOW.values, hideBacks, showTexels: look.showTexels }, 1, 1);
        const light = luminance(value[0], value[1], value[2]);
        return {
            mesh: place[0],
            distance: place[1],
            position: add(view.eye, times(direction, place[1])),
            radiance: place[2],
            isLit: place[3] < 1.5,
            light,
            error: value[3],
        };
    }
}

const ATTRIBUTES = ["position", "normal", "uv", "lightUv", "color"];
const SHADERS = ["surface-vertex", "surface-fragment"];

// A program that the graphics driver goes on to make by itself, while there is other work.
function startProgram(gl) {
    const program = gl.createProgram();
    SHADERS.forEach((id, k) => {
        const shader = gl.createShader(k === 0 ? gl.VERTEX_SHADER : gl.FRAGMENT_SHADER);
        gl.shaderSource(shader, element(id).textContent);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    });
    ATTRIBUTES.forEach((name, place) => gl.bindAttribLocation(program, place, name));
    gl.linkProgram(program);
    return program;
}

function checkProgram(gl, program) {
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
        const logs = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
        throw new Error(`the shaders: ${[...logs, gl.getProgramInfoLog(program)].join(" ")}`);
    }
}

function uniformsOf(gl, program) {
    const uniforms = {};
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
        const { name } = gl.getActiveUniform(program, k);
        uniforms[name] = gl.getUniformLocation(program, name);
    }
    return uniforms;
}

