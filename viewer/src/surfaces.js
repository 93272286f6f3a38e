// The surfaces: face, what is left after the inset, outline, frame and name; those that carry a contact stand out.
import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshLambertMaterial,
} from 'three';
import { CSS2DObject } from 'three/examples/jsm/renderers/CSS2DRenderer.js';
import { setPose } from './data.js';
import { el } from './dom.js';
import { lineMaterial, ring, segments } from './line.js';
import { colour, onTheme } from './theme.js';

export const AXIS_M = 0.12;

/** What can end a face at an edge of its outline, and how such edges are drawn: a solid line where the face ends. */
export const EDGE_KINDS = [
  { name: 'real', label: 'the face ends' },
  { name: 'fold', label: 'another face rises' },
  { name: 'occluded', label: 'hidden by something nearer', dashes: { dashed: true, dashSize: 0.05, gapSize: 0.03 } },
  { name: 'field_of_view', label: 'cut by the view', dashes: { dashed: true, dashSize: 0.012, gapSize: 0.018 } },
  { name: 'unknown', label: 'not measured beyond', dashes: { dashed: true, dashSize: 0.012, gapSize: 0.05 } },
];

/** Flat coordinates of the edges of one kind; all are real where no kinds are given. */
function edgesOf(outline, kinds, name) {
  const all = ring(outline);
  return outline.flatMap((_, i) => ((kinds?.[i] ?? 'real') === name ? all.slice(6 * i, 6 * i + 6) : []));
}

/** Triangles of a convex polygon given counter-clockwise in its plane. */
export function fan(points) {
  const flat = new Float32Array(points.flatMap(([x, y, z]) => [x, y, z ?? 0]));
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(flat, 3));
  geometry.setIndex(points.slice(2).flatMap((_, i) => [0, i + 1, i + 2]));
  geometry.computeVertexNormals();
  return geometry;
}

/** The mesh of triangles in the plane z = 0. */
function triangles(corners) {
  const flat = new Float32Array(corners.flat().flatMap(([x, y]) => [x, y, 0]));
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(flat, 3));
  geometry.computeVertexNormals();
  return geometry;
}

export class SurfacesLayer {
  constructor(stage, surfaces) {
    this.fill = new Group();
    this.inset = new Group();
    this.frames = new Group();
    this.names = new Group();
    this.used = new Set();
    this.pointed = null;
    this.blocked = new Set();
    this.off = new Set();
    this.stage = stage;
    this.parts = new Map();
    this.lines = {
      edge: lineMaterial(stage, 'surface-edge', { linewidth: 1.6 }),
      edgeUsed: lineMaterial(stage, 'surface-used', { linewidth: 2.6 }),
      edgeBlocked: lineMaterial(stage, 'bad', { linewidth: 2.6 }),
      inset: lineMaterial(stage, 'surface-edge', { linewidth: 1.1, dashed: true, dashSize: 0.02, gapSize: 0.014 }),
      outline: Object.fromEntries(EDGE_KINDS.map(({ name, dashes }) =>
        [name, lineMaterial(stage, `edge-${name}`, { linewidth: 1.5, ...dashes })])),
      axes: ['x', 'y', 'z'].map((axis) => lineMaterial(stage, `axis-${axis}`, { linewidth: 2.4 })),
    };
    for (const surface of surfaces) this.add(surface);
    onTheme(() => this.paint());
    stage.afterDraw.push(() => this.thinNames());
  }

  add(surface) {
    const { lines } = this;
    const material = new MeshLambertMaterial({ transparent: true, side: DoubleSide, depthWrite: false });
    const face = new Mesh(triangles(surface.triangles), material);
    face.receiveShadow = true;
    const border = surface.outline.flatMap((points) => ring(points));
    const edge = segments(border, lines.edge);
    const strong = segments(border, lines.edgeUsed);
    face.userData.id = surface.id;
    const blocked = segments(border, lines.edgeBlocked);
    const body = new Group().add(face, edge, strong, blocked);
    const inner = new Group();
    const left = surface.effective.flatMap((points) => ring(points));
    if (left.length) inner.add(segments(left, lines.inset));
    for (const { name } of EDGE_KINDS) {
      const edges = surface.outline.flatMap((outline, i) => edgesOf(outline, surface.outline_edges[i], name));
      if (edges.length) inner.add(segments(edges, lines.outline[name]));
    }
    const frame = new Group();
    lines.axes.forEach((axis, i) => {
      const tip = [0, 0, 0];
      tip[i] = AXIS_M;
      frame.add(segments([0, 0, 0, ...tip], axis));
    });
    const tag = new CSS2DObject(el('span', { class: 'tag' }, surface.id));
    tag.center.set(0.5, -0.3);
    const name = new Group().add(tag);
    for (const [layer, part] of [[this.fill, body], [this.inset, inner], [this.frames, frame], [this.names, name]]) {
      setPose(part, surface.X_WS);
      layer.add(part);
    }
    this.parts.set(surface.id, { material, face, edge, strong, blocked, tag, groups: [body, inner, frame, name] });
  }

  /** Marks the surfaces that carry a contact of the stance. */
  setUsed(ids) {
    this.used = new Set(ids);
    this.paint();
  }

  /** Takes a surface out of the picture. */
  remove(id) {
    const part = this.parts.get(id);
    part.tag.element.remove();
    for (const group of part.groups) group.removeFromParent();
    this.parts.delete(id);
  }

  /** Marks the surfaces where contacts could not be made. */
  setBlocked(ids) {
    this.blocked = new Set(ids);
    this.paint();
  }

  /** Greys the surfaces that nothing may touch. */
  setOff(ids) {
    this.off = new Set(ids);
    this.paint();
  }

  /** Marks the surface that the reader points at in the table. */
  point(id) {
    this.pointed = id;
    this.paint();
  }

  /** Hides the names that others, or the boxes over the picture, cover; those of the marked surfaces come first. */
  thinNames() {
    const tags = [...this.parts.values()].map(({ tag }) => tag.element);
    for (const tag of tags) tag.classList.remove('hidden');
    const over = this.stage.element.querySelectorAll('.layers, .caption, .verdict');
    const shown = [...over].map((box) => box.getBoundingClientRect());
    const rank = (tag) => (tag.classList.contains('used') ? 0 : 1);
    const boxes = tags.map((tag) => ({ tag, box: tag.getBoundingClientRect() }));
    for (const { tag, box } of boxes.sort((a, b) => rank(a.tag) - rank(b.tag))) {
      const covered = shown.some((other) =>
        box.left < other.right && other.left < box.right && box.top < other.bottom && other.top < box.bottom);
      tag.classList.toggle('hidden', covered);
      if (!covered) shown.push(box);
    }
  }

  paint() {
    for (const [id, { material, edge, strong, blocked, tag }] of this.parts) {
      const marked = this.used.has(id) || this.pointed === id;
      const stops = this.blocked.has(id);
      const name = stops ? 'bad' : marked ? 'surface-used' : this.off.has(id) ? 'obstacle' : 'surface';
      material.color.set(colour(name));
      material.opacity = this.pointed === id ? 0.6 : marked || stops ? 0.34 : 0.22;
      blocked.visible = stops;
      edge.visible = !marked && !stops;
      strong.visible = marked && !stops;
      tag.element.classList.toggle('used', marked);
      tag.element.classList.toggle('blocked', stops);
    }
  }
}
