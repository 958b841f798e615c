// Shapes as three.js geometries, in the shape's own frame (z up, as tandem has them).

function uprighted(geometry) {
  return geometry.rotateX(Math.PI / 2);  // three.js builds along y
}

function indexed(vertices, triangles, smooth) {
  let geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(vertices, 3));
  geometry.setIndex(triangles);
  if (!smooth) geometry = geometry.toNonIndexed();
  geometry.computeVertexNormals();
  return geometry;
}

function capsule(radius, length) {
  const half = length / 2, outline = [];
  for (let i = 0; i <= 8; ++i) {
    const angle = -Math.PI / 2 + (i / 8) * (Math.PI / 2);
    outline.push(new THREE.Vector2(radius * Math.cos(angle), -half + radius * Math.sin(angle)));
  }
  for (let i = 0; i <= 8; ++i) {
    const angle = (i / 8) * (Math.PI / 2);
    outline.push(new THREE.Vector2(radius * Math.cos(angle), half + radius * Math.sin(angle)));
  }
  return uprighted(new THREE.LatheBufferGeometry(outline, 16));
}

/// Null for a half-space: it has no end and is drawn as a plane.
export function geometryOf(shape) {
  switch (shape.kind) {
    case "sphere": return new THREE.IcosahedronBufferGeometry(Math.max(shape.radius, 1e-3), 2);
    case "box": return new THREE.BoxBufferGeometry(...shape.size);
    case "capsule": return capsule(shape.radius, shape.length);
    case "cylinder": return uprighted(new THREE.CylinderBufferGeometry(shape.radius, shape.radius, shape.length, 24));
    case "cone": return uprighted(new THREE.ConeBufferGeometry(shape.radius, shape.length, 24));
    case "ellipsoid": return new THREE.SphereBufferGeometry(1, 20, 14).scale(...shape.radii);
    case "halfspace": return null;
    default: return indexed(shape.vertices, shape.triangles, shape.smooth);
  }
}

/// Half the extents and the middle of a shape's box, for picking: {half, middle}.
export function boxOf(geometry) {
  geometry.computeBoundingBox();
  const {min, max} = geometry.boundingBox;
  return {half: [(max.x - min.x) / 2, (max.y - min.y) / 2, (max.z - min.z) / 2], middle: [(max.x + min.x) / 2, (max.y + min.y) / 2, (max.z + min.z) / 2]};
}
