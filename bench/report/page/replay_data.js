// Unpacks a recording; the counterpart of replay.cpp.
import {unpacked} from "report/data.js";

const unzigzag = (v) => (v >>> 1) ^ -(v & 1);

/// n numbers of 16 bits that lie as low bytes, then high bytes, from `at`.
function plane(bytes, at, n) {
  const out = new Uint16Array(n);
  for (let i = 0; i < n; ++i) out[i] = bytes[at + i] | (bytes[at + n + i] << 8);
  return out;
}

const component = (v) => (((v & 0x7fff) / 32767) * 2 - 1) / Math.SQRT2;
/// Quaternion (x, y, z, w) from its three smallest components, into out[at...].
function rotation(c0, c1, c2, out, at) {
  const largest = (c0 >> 15) | ((c1 >> 15) << 1);
  const a = component(c0), b = component(c1), c = component(c2), rest = Math.sqrt(Math.max(0, 1 - a * a - b * b - c * c));
  // Of w x y z the largest was left out.
  out[at + 3] = largest === 0 ? rest : a;
  out[at] = largest === 0 ? a : largest === 1 ? rest : b;
  out[at + 1] = largest <= 1 ? b : largest === 2 ? rest : c;
  out[at + 2] = largest === 3 ? rest : c;
}

/// Float32Array of 7 numbers (translation, quaternion x y z w) a moving body, a frame.
function poses(bytes, about) {
  const n = about.moving.length, width = 6 * n, frames = [];
  let one = new Uint16Array(width), two = one;
  for (let f = 0; f < about.steps.length; ++f) {
    const raw = plane(bytes, 2 * width * f, width), now = new Uint16Array(width);
    for (let i = 0; i < width; ++i) now[i] = unzigzag(raw[i]) + (f === 0 ? 0 : f === 1 ? one[i] : 2 * one[i] - two[i]);
    const out = new Float32Array(7 * n);
    for (let i = 0; i < n; ++i) {
      for (let k = 0; k < 3; ++k) out[7 * i + k] = about.place[k][0] + about.place[k][1] * now[k * n + i];
      rotation(now[3 * n + i], now[4 * n + i], now[5 * n + i], out, 7 * i + 3);
    }
    frames.push(out);
    two = one; one = now;
  }
  return frames;
}

/// Unit vector of its octahedral map.
function unit(u, v, out, at) {
  let x = (u / 255) * 2 - 1, y = (v / 255) * 2 - 1;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
  const length = Math.hypot(x, y, z) || 1;
  out[at] = x / length; out[at + 1] = y / length; out[at + 2] = z / length;
}

/// A frame: {count, a, b, point, normal, depth}; depth >= 0.
function contacts(bytes, about) {
  const view = new DataView(bytes.buffer, bytes.byteOffset), frames = [];
  let at = 0, before = {count: 0};
  for (let f = 0; f < about.steps.length; ++f) {
    const count = view.getUint32(at, true);
    at += 4;
    const columns = [];
    for (let k = 0; k < 8; ++k, at += 2 * count) columns.push(plane(bytes, at, count));
    const now = {count, a: new Uint32Array(count), b: new Uint32Array(count), values: new Uint16Array(6 * count),
      point: new Float32Array(3 * count), normal: new Float32Array(3 * count), depth: new Float32Array(count)};
    let a = 0, b = 0, old = 0;
    for (let i = 0; i < count; ++i) {
      a = (a + unzigzag(columns[0][i])) & 0xffff; b = (b + unzigzag(columns[1][i])) & 0xffff;
      now.a[i] = a; now.b[i] = b;
      while (old < before.count && (before.a[old] < a || (before.a[old] === a && before.b[old] < b))) ++old;
      const known = old < before.count && before.a[old] === a && before.b[old] === b;
      for (let k = 0; k < 6; ++k) now.values[6 * i + k] = unzigzag(columns[2 + k][i]) + (known ? before.values[6 * old + k] : 0);
      if (known) ++old;
      for (let k = 0; k < 3; ++k) now.point[3 * i + k] = about.point[k][0] + about.point[k][1] * now.values[6 * i + k];
      now.depth[i] = about.depth[0] + about.depth[1] * now.values[6 * i + 3];
      unit(now.values[6 * i + 4], now.values[6 * i + 5], now.normal, 3 * i);
    }
    frames.push(now);
    before = now;
  }
  for (const frame of frames) delete frame.values;
  return frames;
}

/// At some frames, a body: candidate pairs and narrow-phase time in ns. {frames, candidates, narrow}
function costs(bytes, about) {
  const n = about.bodies, out = {frames: about.cost.frames, candidates: [], narrow: []};
  out.frames.forEach((_, i) => {
    out.candidates.push(plane(bytes, 4 * n * i, n));
    out.narrow.push(Float32Array.from(plane(bytes, 4 * n * i + 2 * n, n), (v) => 2 ** (v / 2048) - 1));
  });
  return out;
}

export async function readReplay(number, about) {
  const [p, c, k] = await Promise.all(["poses", "contacts", "costs"].map((part) => unpacked(`replay-${number}-${part}`)));
  return {about, poses: poses(p, about), contacts: contacts(c, about), costs: costs(k, about)};
}

/// Number of the cost measurement in force at a frame.
export const costAt = (replay, frame) => Math.max(0, d3.bisectRight(replay.costs.frames, frame) - 1);
