// The replay with WebGL: bodies as instances, one draw a shape.
import {geometryOf, boxOf} from "report/geometry.js";
import {valueOf} from "report/theme.js";

export class StageGl {
  /// Throws where there is no WebGL.
  constructor(canvas, bodies) {
    if (document.createElement("canvas").getContext("webgl") === null) throw new Error("no WebGL here");
    this.canvas = canvas;
    this.bodies = bodies;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.05, 4000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => (this.dirty = true));
    this.light();
    this.build();
    this.buildContacts();
    this.theme();
    this.lookAtAll();
  }

  light() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0x8d8a85, 0.72);
    this.sky.position.set(0, 0, 1);
    const sun = new THREE.DirectionalLight(0xffffff, 0.55);
    sun.position.set(0.5, -0.8, 1.4);
    this.scene.add(this.sky, sun);
  }

  build() {
    const {about} = this.bodies.replay;
    this.groups = [];
    this.place = new Array(about.bodies);  // of a body: its group and its number there
    const still = new Set(about.still.map((s) => s.body));
    about.shapes.forEach((shape, s) => {
      const all = d3.range(about.bodies).filter((body) => about.shape_of[body] === s);
      const geometry = geometryOf(shape);
      if (geometry === null) return all.forEach((body) => this.addPlane(shape, body));
      const box = boxOf(geometry);
      // What stands still may enclose the rest: its back sides are drawn only.
      for (const [list, fixed] of [[all.filter((b) => !still.has(b)), false], [all.filter((b) => still.has(b)), true]]) {
        if (list.length === 0) continue;
        const own = geometry.clone();
        const colours = new THREE.InstancedBufferAttribute(new Float32Array(3 * list.length).fill(0.6), 3);
        own.setAttribute("color", colours);
        const material = new THREE.MeshLambertMaterial({vertexColors: THREE.VertexColors, side: fixed ? THREE.BackSide : THREE.FrontSide});
        const mesh = new THREE.InstancedMesh(own, material, list.length);
        mesh.frustumCulled = false;
        const group = {list, mesh, colours, box, fixed};
        list.forEach((body, i) => (this.place[body] = {group, i}));
        this.groups.push(group);
        this.scene.add(mesh);
        if (fixed && shape.kind !== "mesh") material.side = THREE.FrontSide;
      }
    });
  }

  addPlane(shape, body) {
    const matrix = new THREE.Matrix4();
    this.bodies.matrix(body, matrix.elements, 0);
    const radius = Math.ceil(2.2 * this.bodies.extent().radius);
    const mesh = new THREE.Mesh(new THREE.PlaneBufferGeometry(2 * radius, 2 * radius), new THREE.MeshLambertMaterial({side: THREE.DoubleSide}));
    const normal = new THREE.Vector3(...shape.normal);
    mesh.position.copy(normal).multiplyScalar(shape.offset);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
    mesh.applyMatrix(matrix);
    const grid = new THREE.GridHelper(2 * radius, 2 * Math.min(radius, 40), 0x888888, 0x888888);
    grid.rotation.x = Math.PI / 2;
    grid.position.z = 0.004 * radius;
    grid.material.transparent = true;
    grid.material.opacity = 0.22;
    mesh.add(grid);
    this.ground = mesh;
    this.scene.add(mesh);
  }

  buildContacts() {
    const most = Math.max(1, ...this.bodies.replay.contacts.map((c) => c.count));
    this.points = new Float32Array(3 * most);
    this.lines = new Float32Array(6 * most);
    const attribute = (array) => new THREE.BufferAttribute(array, 3);
    const geometry = (array) => { const g = new THREE.BufferGeometry(); g.setAttribute("position", attribute(array)); return g; };
    this.dots = new THREE.Points(geometry(this.points), new THREE.PointsMaterial({size: 4, sizeAttenuation: false, depthTest: false, transparent: true}));
    this.normals = new THREE.LineSegments(geometry(this.lines), new THREE.LineBasicMaterial({depthTest: false, transparent: true}));
    for (const object of [this.dots, this.normals]) { object.frustumCulled = false; object.renderOrder = 2; object.visible = false; this.scene.add(object); }
  }

  theme() {
    this.scene.background = new THREE.Color(valueOf("--page"));
    if (this.ground) this.ground.material.color = new THREE.Color(valueOf("--ground"));
    const mark = new THREE.Color(valueOf("--bad"));
    this.dots.material.color = mark;
    this.normals.material.color = mark;
    this.dirty = true;
  }

  lookAtAll() {
    const {middle, half, radius} = this.bodies.extent();
    const forward = new THREE.Vector3(-0.46, 0.74, -0.5).normalize(), right = new THREE.Vector3().crossVectors(forward, this.camera.up).normalize(), up = new THREE.Vector3().crossVectors(right, forward);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360), wide = tall * (this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight) || 1);
    // As near as the eight corners of what moves allow.
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = new THREE.Vector3(...half.map((x, k) => (i & (1 << k) ? x : -x)));
      const depth = corner.dot(forward);
      distance = Math.max(distance, Math.abs(corner.dot(right)) / wide - depth, Math.abs(corner.dot(up)) / tall - depth);
    }
    this.controls.target.set(...middle);
    this.camera.position.set(...middle).addScaledVector(forward, -(1.04 * distance + 0.5));
    this.camera.far = 40 * radius;
    this.camera.near = radius / 200;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.dirty = true;
  }

  /// Goes near a body, seen from the side that is seen now.
  lookAt(body) {
    const {radius} = this.bodies.extent(), at = new THREE.Vector3().fromArray(this.bodies.pose, 7 * body);
    const back = this.camera.position.clone().sub(this.controls.target).setLength(Math.max(0.36 * radius, 1));
    this.controls.target.copy(at);
    this.camera.position.copy(at).add(back);
    this.controls.update();
    this.dirty = true;
  }

  /// The bodies moved.
  moved() {
    for (const {list, mesh} of this.groups) {
      list.forEach((body, i) => this.bodies.matrix(body, mesh.instanceMatrix.array, 16 * i));
      mesh.instanceMatrix.needsUpdate = true;
    }
    this.dirty = true;
  }

  /// colourOf(body): [r, g, b] in 0..1.
  paint(colourOf) {
    for (const {list, colours} of this.groups) {
      list.forEach((body, i) => colours.array.set(colourOf(body), 3 * i));
      colours.needsUpdate = true;
    }
    this.dirty = true;
  }

  /// contacts: a frame's, or null for none; keep(i): whether the i-th is drawn. Returns how many are.
  showContacts(contacts, keep, length) {
    this.dots.visible = this.normals.visible = contacts !== null;
    this.dirty = true;
    if (contacts === null) return 0;
    let n = 0;
    for (let i = 0; i < contacts.count; ++i) {
      if (!keep(i)) continue;
      for (let k = 0; k < 3; ++k) {
        const p = contacts.point[3 * i + k];
        this.points[3 * n + k] = p;
        this.lines[6 * n + k] = p;
        this.lines[6 * n + 3 + k] = p + length * contacts.normal[3 * i + k];
      }
      ++n;
    }
    this.dots.geometry.attributes.position.needsUpdate = true;
    this.normals.geometry.attributes.position.needsUpdate = true;
    this.dots.geometry.setDrawRange(0, n);
    this.normals.geometry.setDrawRange(0, 2 * n);
    return n;
  }

  /// The moving body under a point of the canvas (CSS pixels), or null: the nearest whose box the ray meets.
  pick(px, py) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * px) / this.canvas.clientWidth - 1, 1 - (2 * py) / this.canvas.clientHeight), this.camera);
    let best = null, nearest = Infinity;
    const m = new THREE.Matrix4(), inverse = new THREE.Matrix4(), own = new THREE.Ray(), box = new THREE.Box3(), hit = new THREE.Vector3();
    for (const {list, box: {half, middle}, fixed} of this.groups) {
      if (fixed) continue;
      box.min.set(...middle.map((x, k) => x - half[k]));
      box.max.set(...middle.map((x, k) => x + half[k]));
      for (const body of list) {
        this.bodies.matrix(body, m.elements, 0);
        inverse.getInverse(m);
        own.copy(ray.ray).applyMatrix4(inverse);
        if (!own.intersectBox(box, hit)) continue;
        const distance = hit.distanceTo(own.origin);
        if (distance < nearest) { nearest = distance; best = body; }
      }
    }
    return best;
  }

  draw() {
    const {clientWidth: w, clientHeight: h} = this.canvas;
    if (w !== this.width || h !== this.height) {
      [this.width, this.height] = [w, h];
      this.renderer.setSize(w, h, false);
      this.camera.aspect = w / Math.max(1, h);
      this.camera.updateProjectionMatrix();
      this.dirty = true;
    }
    if (!this.dirty) return false;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    return true;
  }
}
