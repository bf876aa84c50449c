#!/usr/bin/env bash
# Babylon.js 9.35.0: EXT_lights_image_based names a paper for its coefficients (Ramamoorthi and Hanrahan 2001), whose basis
# functions of the second band are y, z and x. The only reader of the extension takes -y, z and -x (and looks z up reversed
# in a scene of right-handed axes): a sky above, written with the signs of the paper, lights what faces down. Here are the
# steps of its loader on the irradiance of a sky of radiance 1 above and nothing below, pi (1 + y) / 2: found is twice the
# irradiance of what faces down, and none of what faces up. With the band negated it is right.
#
# Needs Node.js, npm and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm install --prefix "$work" --ignore-scripts --silent babylonjs@9.35.0 > /dev/null
cat > "$work/sky.cjs" <<'JS'
const B = require("babylonjs");
const irradiance = (sign, y) => {
    const coefficients = Array.from({ length: 9 }, () => [0, 0, 0]);
    coefficients[0] = Array(3).fill(Math.PI / 2 / 0.282095);
    coefficients[1] = Array(3).fill((sign * Math.PI) / 2 / 0.488603);
    const harmonics = B.SphericalHarmonics.FromArray(coefficients);
    harmonics.convertIrradianceToLambertianRadiance();
    const { l00, l1_1 } = B.SphericalPolynomial.FromHarmonics(harmonics).preScaledHarmonics;
    return Math.PI * (l00.x + l1_1.x * y) + 1e-9;
};
for (const [name, sign] of [["paper", 1], ["negated", -1]]) {
    console.log(`${name}: up ${irradiance(sign, 1).toFixed(2)}, down ${irradiance(sign, -1).toFixed(2)}`);
}
JS
seen=$(cd "$work" && node sky.cjs | grep up)
echo "$seen"
# As seen with Babylon.js 9.35.0.
expected='paper: up 0.00, down 3.14
negated: up 3.14, down 0.00'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
