// Contact patches of the stance, the forces on them, and every place the plan will touch.
import { ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import { lineMaterial, ring, segments } from './line.js';
import { fan } from './surfaces.js';
import { colour, onTheme } from './theme.js';

const UP = new Vector3(0, 1, 0);
const LIFT_M = 0.003;
/** The robot's weight is drawn this long, of the height of the CoM at the start. */
const WEIGHT_SHARE = 0.6;
/** Forces below this part of the weight are not drawn. */
const SMALLEST_SHARE = 0.004;

const SHAFT = new CylinderGeometry(1, 1, 1, 16).translate(0, 0.5, 0);
const TIP = new ConeGeometry(1, 1, 24).translate(0, 0.5, 0);

function themed(name, options) {
  const material = new MeshBasicMaterial(options);
  onTheme(() => material.color.set(colour(name)));
  return material;
}

/** Drawn twice: in front as it is, and faintly through what hides it. */
function visibleThrough(name) {
  return [
    themed(name, { transparent: true }),
    themed(name, { transparent: true, opacity: 0.42, depthTest: false, depthWrite: false }),
  ];
}

/** An arrow from `tail` along `vector`, m. */
function arrow(tail, vector, radius, materials) {
  const length = vector.length();
  const head = Math.min(5 * radius, 0.6 * length);
  const group = new Group();
  for (const [k, material] of materials.entries()) {
    const shaft = new Mesh(SHAFT, material);
    shaft.scale.set(radius, length - head, radius);
    const tip = new Mesh(TIP, material);
    tip.scale.set(2.4 * radius, head, 2.4 * radius);
    tip.position.y = length - head;
    shaft.renderOrder = tip.renderOrder = k ? 20 : 10;
    group.add(shaft, tip);
  }
  group.position.copy(tail);
  group.quaternion.setFromUnitVectors(UP, vector.clone().divideScalar(length));
  return group;
}

export class ContactsLayer {
  constructor(stage, data) {
    const [first] = data.stances;
    const height = first ? first.com_W[2] - first.support_level_m : 0;
    this.weightLength = WEIGHT_SHARE * (height > 0.05 ? height : 1);
    /** Length per force, m/N. */
    this.scale = this.weightLength / data.robot.weight_N;
    this.patches = new Group();
    this.forces = new Group();
    this.places = new Group();
    this.fills = {
      loaded: themed('loaded', { transparent: true, opacity: 0.85, side: DoubleSide, depthWrite: false }),
      unloaded: themed('unloaded', { transparent: true, opacity: 0.3, side: DoubleSide, depthWrite: false }),
    };
    this.edges = {
      loaded: lineMaterial(stage, 'loaded', { linewidth: 2.5 }),
      unloaded: lineMaterial(stage, 'unloaded', { linewidth: 3 }),
    };
    this.force = visibleThrough('force');
    this.weight = visibleThrough('weight');
    this.addPlaces(stage, data.stances);
  }

  /** Outlines of all contacts of the plan, each place once. */
  addPlaces(stage, stances) {
    const seen = new Set();
    const outlines = [];
    for (const contact of stances.flatMap((stance) => stance.contacts)) {
      const key = `${contact.patch} ${contact.vertices_W}`;
      if (seen.has(key)) continue;
      seen.add(key);
      outlines.push(...ring(contact.vertices_W, lift(contact)));
    }
    if (outlines.length) {
      this.places.add(segments(outlines, lineMaterial(stage, 'place', { linewidth: 1.3 })));
    }
  }

  show(stance) {
    for (const group of [this.patches, this.forces]) dispose(group);
    for (const contact of stance.contacts) {
      const state = contact.loaded ? 'loaded' : 'unloaded';
      const raised = lift(contact);
      const face = new Mesh(fan(contact.vertices_W), this.fills[state]);
      face.position.copy(raised);
      face.renderOrder = 2;
      this.patches.add(face, segments(ring(contact.vertices_W, raised), this.edges[state]));
      contact.forces_W.forEach((f, k) => this.addForce(contact.force_points_W[k], f, 0.004));
      if (contact.centre_of_pressure_W) this.addForce(contact.centre_of_pressure_W, contact.force_W, 0.009);
    }
    const weight = new Vector3(0, 0, -this.weightLength);
    this.forces.add(arrow(new Vector3(...stance.com_W), weight, 0.007, this.weight));
  }

  addForce(point, force, radius) {
    const vector = new Vector3(...force).multiplyScalar(this.scale);
    if (vector.length() < SMALLEST_SHARE * this.weightLength) return;
    this.forces.add(arrow(new Vector3(...point), vector, radius, this.force));
  }
}

/** A little above the surface, so that the patch is not lost in it. */
function lift(contact) {
  return new Vector3(...contact.normal_W).multiplyScalar(LIFT_M);
}

/** Empties a group; geometries made for one stance go, shared ones stay. */
export function dispose(group) {
  group.traverse((node) => {
    if (node.geometry && node.geometry !== SHAFT && node.geometry !== TIP) node.geometry.dispose();
  });
  group.clear();
}

