// Lines thicker than a pixel, the colour by its name in the style sheet.
import { Vector3 } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { colour, onTheme } from './theme.js';

/** A material that follows the theme; `options` are those of LineMaterial. */
export function lineMaterial(stage, name, options) {
  const material = stage.adoptLine(new LineMaterial({ linewidth: 2, ...options }));
  onTheme(() => material.color.set(colour(name)));
  return material;
}

/** Segments from flat coordinates, six a segment. */
export function segments(coordinates, material) {
  const geometry = new LineSegmentsGeometry().setPositions(coordinates);
  const line = new LineSegments2(geometry, material);
  if (material.dashed) line.computeLineDistances();
  return line;
}

/** Flat coordinates of the segments that close a ring of points. */
export function ring(points, lift = new Vector3()) {
  return points.flatMap((p, i) => {
    const q = points[(i + 1) % points.length];
    return [...at(p, lift), ...at(q, lift)];
  });
}

const at = (p, lift) => [p[0] + lift.x, p[1] + lift.y, (p[2] ?? 0) + lift.z];
