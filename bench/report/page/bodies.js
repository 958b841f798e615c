// Where every body of a replay is at a moment between two frames.

export class Bodies {
  constructor(replay) {
    const {about} = replay;
    this.replay = replay;
    this.count = about.bodies;
    this.pose = new Float32Array(7 * this.count);  // translation, quaternion x y z w
    for (const {body, t, q} of about.still) this.pose.set([...t, ...q], 7 * body);
    this.at(0);
  }

  /// Straight between frames, rotations along the shorter way.
  at(time) {
    const {poses, about} = this.replay;
    const f = Math.min(poses.length - 1, Math.floor(time)), g = Math.min(poses.length - 1, f + 1), w = time - f;
    const from = poses[f], to = poses[g], out = this.pose;
    about.moving.forEach((body, i) => {
      const s = 7 * i, d = 7 * body;
      for (let k = 0; k < 3; ++k) out[d + k] = from[s + k] + w * (to[s + k] - from[s + k]);
      const dot = from[s + 3] * to[s + 3] + from[s + 4] * to[s + 4] + from[s + 5] * to[s + 5] + from[s + 6] * to[s + 6];
      const v = dot < 0 ? -w : w;
      let sum = 0;
      for (let k = 3; k < 7; ++k) { out[d + k] = (1 - w) * from[s + k] + v * to[s + k]; sum += out[d + k] ** 2; }
      const scale = 1 / Math.sqrt(sum || 1);
      for (let k = 3; k < 7; ++k) out[d + k] *= scale;
    });
  }

  /// The column-major 4 x 4 matrix of a body into out[at...].
  matrix(body, out, at) {
    const p = this.pose, i = 7 * body, x = p[i + 3], y = p[i + 4], z = p[i + 5], w = p[i + 6];
    out[at] = 1 - 2 * (y * y + z * z); out[at + 1] = 2 * (x * y + z * w); out[at + 2] = 2 * (x * z - y * w); out[at + 3] = 0;
    out[at + 4] = 2 * (x * y - z * w); out[at + 5] = 1 - 2 * (x * x + z * z); out[at + 6] = 2 * (y * z + x * w); out[at + 7] = 0;
    out[at + 8] = 2 * (x * z + y * w); out[at + 9] = 2 * (y * z - x * w); out[at + 10] = 1 - 2 * (x * x + y * y); out[at + 11] = 0;
    out[at + 12] = p[i]; out[at + 13] = p[i + 1]; out[at + 14] = p[i + 2]; out[at + 15] = 1;
  }

  /// Box around the bodies that move, at the present moment, without the outermost hundredth: {middle, half, radius}.
  extent() {
    const {moving} = this.replay.about, middle = [], size = [];
    for (let k = 0; k < 3; ++k) {
      const sorted = Float32Array.from(moving, (body) => this.pose[7 * body + k]).sort();
      const lo = sorted[Math.floor(0.01 * (sorted.length - 1))] ?? -1, hi = sorted[Math.ceil(0.99 * (sorted.length - 1))] ?? 1;
      middle.push((lo + hi) / 2);
      size.push(hi - lo);
    }
    return {middle, half: size.map((x) => x / 2), radius: Math.max(1, Math.hypot(...size) / 2)};
  }
}
