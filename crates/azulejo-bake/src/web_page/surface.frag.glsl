#version 300 es
// Radiance, values, and what is shown of them.
precision highp float;
precision highp int;

in vec3 fromEye;
in vec3 vertexNormal;
in vec2 pictureUv;
centroid in vec2 mapUv;
in vec3 vertexColor;

// The material.
uniform sampler2D picture;
uniform vec3 baseColor;
uniform vec3 emission;
uniform float cutoff;
uniform float opacity;
uniform bool isUnlit;

// Irradiance in rgb, luminance of its standard error in alpha, each times a scale.
uniform sampler2D light;
uniform vec2 lightScale;
uniform bool isLit;
uniform float meshNumber;

// What to show; the numbers are those of SHOW in renderer.js.
uniform int show;
uniform float exposure;
uniform int tone;
uniform sampler2D ramp;
uniform vec2 range;
uniform bool isLogarithmic;
uniform bool showTexels;

out vec4 result;

const float PI = 3.14159265358979;

float luminance(vec3 c) {
    return dot(c, vec3(0.2126, 0.7152, 0.0722));
}

vec4 lightHere() {
    if (!isLit) {
        return vec4(0.0);
    }
    vec4 texel = texture(light, mapUv);
    if (showTexels) {
        ivec2 size = textureSize(light, 0);
        ivec2 place = clamp(ivec2(mapUv * vec2(size)), ivec2(0), size - 1);
        texel = texelFetch(light, place, 0);
    }
    return texel * lightScale.xxxy;
}

// Narkowicz, ACES Filmic Tone Mapping Curve, 2015, with the factor 0.6 that aligns its exposure.
vec3 filmic(vec3 c) {
    vec3 x = 0.6 * min(c, 1e4);
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// Reinhard et al., Photographic Tone Reproduction for Digital Images, 2002, eq. (4), white at 6.
vec3 reinhard(vec3 c) {
    float l = luminance(c);
    return c * ((1.0 + l / 36.0) / (1.0 + l));
}

vec3 displayed(vec3 radiance) {
    vec3 exposed = radiance * exposure;
    if (tone == 1) {
        exposed = filmic(exposed);
    } else if (tone == 2) {
        exposed = reinhard(exposed);
    }
    return clamp(exposed, 0.0, 1.0);
}

vec3 encoded(vec3 c) {
    vec3 low = 12.92 * c;
    vec3 high = 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055;
    // Half a step of noise in screen space hides the bands that 8 bits leave on dark walls.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    return mix(high, low, lessThanEqual(c, vec3(0.0031308))) + (noise - 0.5) / 255.0;
}

// A lamp at the eye; surfaces without normals are flat.
float headlight() {
    vec3 flatNormal = cross(dFdx(fromEye), dFdy(fromEye));
    bool isGiven = dot(vertexNormal, vertexNormal) > 0.25;
    vec3 n = isGiven ? vertexNormal : flatNormal;
    float facing = abs(dot(n, fromEye)) / max(length(n) * length(fromEye), 1e-30);
    return 0.25 + 0.75 * facing;
}

vec3 falseColor(float value) {
    float t = isLogarithmic
        ? log(max(value, 1e-30) / range.x) / log(range.y / range.x)
        : (value - range.x) / (range.y - range.x);
    return texture(ramp, vec2((0.5 + 255.0 * clamp(t, 0.0, 1.0)) / 256.0, 0.5)).rgb;
}

// Light and dark texels in turn, in squares of 2^n texels so that they never get too small to see.
vec3 withTexels(vec3 color) {
    vec2 place = mapUv * vec2(textureSize(light, 0));
    vec2 across = max(abs(dFdx(place)), abs(dFdy(place)));
    float side = exp2(max(0.0, ceil(log2(5.0 * max(across.x, across.y)))));
    vec2 squares = floor(place / side);
    float isDark = mod(squares.x + squares.y, 2.0);
    return isDark > 0.5 ? color * 0.72 : mix(color, vec3(1.0), 0.06);
}

void main() {
    vec4 texel = texture(picture, pictureUv);
    if (texel.a < cutoff) {
        discard;
    }
    float alpha = opacity < 0.0 ? 1.0 : opacity * texel.a;
    vec3 reflectance = baseColor * texel.rgb * vertexColor;
    vec4 e = lightHere();
    vec3 radiance = isUnlit ? reflectance : reflectance * e.rgb / PI + emission;
    if (show >= 5 && alpha < 0.5) {
        discard;
    }
    if (show == 4) {
        result = vec4(radiance, alpha);
        return;
    }
    if (show == 5) {
        result = isLit ? e : vec4(0.0);
        return;
    }
    if (show == 6) {
        result = vec4(meshNumber, length(fromEye), luminance(radiance), isLit ? 1.0 : 2.0);
        return;
    }
    vec3 color;
    if (show == 0) {
        color = encoded(isUnlit ? clamp(reflectance, 0.0, 1.0) : displayed(radiance));
    } else if (show == 1 || !isLit) {
        float brightest = max(max(emission.r, emission.g), max(emission.b, 1e-30));
        vec3 lamp = luminance(emission) > 0.0 ? 0.9 * emission / brightest : vec3(0.0);
        vec3 plain = max(reflectance * (isUnlit ? 1.0 : headlight()), lamp);
        color = encoded(clamp(plain, 0.0, 1.0));
        if (show != 1) {
            // Nothing is known of its light: a grey that no colour of a ramp resembles.
            color = vec3(0.18 + 0.14 * luminance(color));
        }
    } else if (show == 2) {
        color = falseColor(luminance(e.rgb));
    } else {
        color = falseColor(100.0 * e.a / max(luminance(e.rgb), 1e-30));
    }
    if (showTexels && isLit) {
        color = withTexels(color);
    }
    result = vec4(color, alpha);
}
