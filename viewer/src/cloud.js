// The scan: points coloured by their height.
import { BufferAttribute, BufferGeometry, Color, Points, PointsMaterial } from 'three';
import { colour, onTheme } from './theme.js';

const STOPS = 5;

/** The colours of the height scale, low to high, as the style sheet has them. */
export function heightScale() {
  return Array.from({ length: STOPS }, (_, i) => colour(`height-${i}`));
}

/** Heights of the 1st and 99th percentile, between which the colours run. */
export function heightRange(xyz) {
  const heights = Float32Array.from({ length: xyz.length / 3 }, (_, i) => xyz[3 * i + 2]).sort();
  const last = heights.length - 1;
  return [heights[Math.floor(0.01 * last)], heights[Math.ceil(0.99 * last)]];
}

/** The points in W; `range` is that of the colours. */
export function cloudLayer(xyz, range) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(xyz, 3));
  const colours = new Float32Array(xyz.length);
  geometry.setAttribute('color', new BufferAttribute(colours, 3));
  const material = new PointsMaterial({ size: 0.009, vertexColors: true });
  const span = Math.max(range[1] - range[0], 1e-3);
  const [low, mixed] = [new Color(), new Color()];
  onTheme(() => {
    const stops = heightScale().map((c) => new Color(c));
    for (let i = 0; i < xyz.length; i += 3) {
      const t = Math.min(Math.max((xyz[i + 2] - range[0]) / span, 0), 1) * (STOPS - 1);
      const k = Math.min(Math.floor(t), STOPS - 2);
      low.copy(stops[k]);
      mixed.copy(low).lerp(stops[k + 1], t - k).toArray(colours, i);
    }
    geometry.attributes.color.needsUpdate = true;
  });
  return new Points(geometry, material);
}
