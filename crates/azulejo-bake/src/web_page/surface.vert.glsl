#version 300 es
// Surfaces, relative to the eye: large coordinates stay exact near it.
precision highp float;

in vec3 position;
in vec3 normal;
in vec2 uv;
in vec2 lightUv;
in vec3 color;

uniform vec3 eye;
uniform mat4 viewProjection;

out vec3 fromEye;
out vec3 vertexNormal;
out vec2 pictureUv;
// At the edges of triangles, where a pixel is only partly covered, the light is that of the covered part.
centroid out vec2 mapUv;
out vec3 vertexColor;

void main() {
    fromEye = position - eye;
    vertexNormal = normal;
    // Texture coordinates grow upwards, rows of pictures downwards.
    pictureUv = vec2(uv.x, 1.0 - uv.y);
    mapUv = lightUv;
    vertexColor = color;
    gl_Position = viewProjection * vec4(fromEye, 1.0);
}
