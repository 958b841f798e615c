// The replay without WebGL: every body a disc of its size, seen from one side; dragging turns the view.
import {geometryOf} from "report/geometry.js";
import {valueOf} from "report/theme.js";

export class StageFlat {
  constructor(canvas, bodies) {
    this.canvas = canvas;
    this.bodies = bodies;
    this.context = canvas.getContext("2d");
    this.turn = 0.6;
    this.contacts = null;
    const {about} = bodies.replay;
    const sizes = about.shapes.map((shape) => {
      const geometry = geometryOf(shape);
      if (geometry === null) return 0;
      geometry.computeBoundingSphere();
      return geometry.boundingSphere.radius;
    });
    this.radius = about.shape_of.map((shape) => sizes[shape]);
    this.colours = about.shape_of.map(() => "#888");
    this.lookAtAll();
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 1) return;
      this.turn += 0.01 * event.movementX;
      this.dirty = true;
    });
  }
  lookAtAll() { this.view = this.bodies.extent(); this.dirty = true; }
  lookAt(body) {
    const {pose} = this.bodies, {radius} = this.bodies.extent();
    this.view = {middle: [...pose.slice(7 * body, 7 * body + 3)], radius: Math.max(0.36 * radius, 1)};
    this.dirty = true;
  }
  theme() { this.dirty = true; }
  moved() { this.dirty = true; }
  paint(colourOf) {
    this.colours = this.colours.map((_, body) => `rgb(${colourOf(body).map((c) => Math.round(255 * c)).join()})`);
    this.dirty = true;
  }
  showContacts(contacts, keep) {
    this.contacts = contacts === null ? null : {contacts, keep};
    this.dirty = true;
    return contacts === null ? 0 : d3.range(contacts.count).filter(keep).length;
  }

  /// Canvas position, distance from the eye and pixels a metre of a point.
  project(x, y, z) {
    const {middle, radius} = this.view, c = Math.cos(this.turn), s = Math.sin(this.turn), tilt = 0.5;
    const u = c * (x - middle[0]) + s * (y - middle[1]), v = c * (y - middle[1]) - s * (x - middle[0]), w = z - middle[2];
    const scale = (0.42 * Math.min(this.canvas.width, this.canvas.height)) / radius;
    return {x: this.canvas.width / 2 + scale * u, y: this.canvas.height / 2 - scale * (w * Math.cos(tilt) + v * Math.sin(tilt)),
      depth: v * Math.cos(tilt) - w * Math.sin(tilt), scale};
  }
  discs() {
    const {pose, replay} = this.bodies;
    return replay.about.moving.map((body) => ({body, ...this.project(pose[7 * body], pose[7 * body + 1], pose[7 * body + 2])})).sort((p, q) => q.depth - p.depth);
  }
  pick(px, py) {
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const hit = this.discs().reverse().find((d) => Math.hypot(d.x - px * ratio, d.y - py * ratio) < this.radius[d.body] * d.scale);
    return hit ? hit.body : null;
  }
  draw() {
    const {clientWidth: w, clientHeight: h} = this.canvas;
    if (this.canvas.width !== w || this.canvas.height !== h) { this.canvas.width = w; this.canvas.height = h; this.dirty = true; }
    if (!this.dirty) return false;
    this.dirty = false;
    const {context} = this;
    context.fillStyle = valueOf("--page");
    context.fillRect(0, 0, w, h);
    context.strokeStyle = "rgba(0,0,0,.35)";
    for (const d of this.discs()) {
      context.beginPath();
      context.arc(d.x, d.y, Math.max(1, 0.8 * this.radius[d.body] * d.scale), 0, 2 * Math.PI);
      context.fillStyle = this.colours[d.body];
      context.fill();
      context.stroke();
    }
    if (this.contacts) {
      const {contacts, keep} = this.contacts;
      context.fillStyle = valueOf("--bad");
      for (let i = 0; i < contacts.count; ++i) if (keep(i)) {
        const p = this.project(contacts.point[3 * i], contacts.point[3 * i + 1], contacts.point[3 * i + 2]);
        context.fillRect(p.x - 1, p.y - 1, 2, 2);
      }
    }
    return true;
  }
}
