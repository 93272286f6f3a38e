// The robot: its bodies' shapes, posed by the data; no kinematics here.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CylinderGeometry, EdgesGeometry, Group,
  LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial, Object3D,
  SphereGeometry, Vector3,
} from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { setPose } from './data.js';
import { colour, isDark, onTheme } from './theme.js';

const EDGE_ANGLE_DEG = 28;
const TURN_Y_TO_Z = new Matrix4().makeRotationX(Math.PI / 2);

/** The shape in its own frame; cylinders and capsules lie along z. */
function shapeGeometry(shape) {
  switch (shape.kind) {
    case 'box':
      return new BoxGeometry(...shape.half_extents_m.map((h) => 2 * h));
    case 'sphere':
      return new SphereGeometry(shape.radius_m, 32, 20);
    case 'cylinder':
      return new CylinderGeometry(shape.radius_m, shape.radius_m, 2 * shape.half_length_m, 40)
        .applyMatrix4(TURN_Y_TO_Z);
    case 'capsule':
      return new CapsuleGeometry(shape.radius_m, 2 * shape.half_length_m, 10, 32)
        .applyMatrix4(TURN_Y_TO_Z);
    case 'mesh': {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(new Float32Array(shape.vertices_m), 3));
      geometry.setIndex(shape.triangles);
      return geometry;
    }
    default:
      throw new Error(`unknown shape ${shape.kind}`);
  }
}

/** All shapes of a body in one geometry, in the body's frame. */
function bodyGeometry(body) {
  const placed = body.shapes.map((shape) => {
    const place = new Object3D();
    setPose(place, shape.X_BG);
    place.updateMatrix();
    const indexed = shapeGeometry(shape);
    const flat = indexed.index ? indexed.toNonIndexed() : indexed;
    flat.deleteAttribute('uv');
    if (shape.kind === 'mesh') flat.computeVertexNormals();
    return flat.applyMatrix4(place.matrix);
  });
  return placed.length ? mergeGeometries(placed) : null;
}

export class RobotLayer {
  constructor(robot) {
    this.geometries = robot.bodies.map(bodyGeometry);
    this.edges = this.geometries.map((g) => g && new EdgesGeometry(g, EDGE_ANGLE_DEG));
    this.solid = this.build(solidBody());
    this.ghost = this.build(ghostBody());
  }

  /** The corners of a box around each body, in the body's frame; its origin where it has no shape. */
  boxes() {
    return this.geometries.map((geometry) => {
      if (!geometry) return [new Vector3()];
      geometry.computeBoundingBox();
      const { min, max } = geometry.boundingBox;
      return [0, 1, 2, 3, 4, 5, 6, 7].map((k) =>
        new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z));
    });
  }

  build(makeBody) {
    const group = new Group();
    this.geometries.forEach((geometry, i) => {
      const body = new Group();
      if (geometry) body.add(...makeBody(geometry, this.edges[i]));
      group.add(body);
    });
    return group;
  }

  /** Puts the bodies at the poses of a stance, seven numbers a body. */
  static pose(group, poses) {
    group.children.forEach((body, i) => setPose(body, poses, 7 * i));
  }
}

function solidBody() {
  const skin = new MeshStandardMaterial({ roughness: 0.62, metalness: 0.05 });
  const line = new LineBasicMaterial({ transparent: true });
  onTheme(() => {
    skin.color.set(colour('robot'));
    line.color.set(colour('robot-edge'));
    line.opacity = isDark() ? 0.75 : 0.55;
  });
  return (geometry, edges) => {
    const mesh = new Mesh(geometry, skin);
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    return [mesh, new LineSegments(edges, line)];
  };
}

/** Only the nearest face of the ghost is drawn: its depth first, then its colour. */
function ghostBody() {
  const depth = new MeshBasicMaterial({ colorWrite: false });
  const skin = new MeshBasicMaterial({ transparent: true, opacity: 0.2, depthWrite: false });
  const line = new LineBasicMaterial({ transparent: true, opacity: 0.45, depthWrite: false });
  onTheme(() => {
    skin.color.set(colour('ghost'));
    line.color.set(colour('ghost'));
  });
  return (geometry, edges) => {
    const first = new Mesh(geometry, depth);
    first.renderOrder = 5;
    const second = new Mesh(geometry, skin);
    second.renderOrder = 6;
    const outline = new LineSegments(edges, line);
    outline.renderOrder = 7;
    return [first, second, outline];
  };
}
