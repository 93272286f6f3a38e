// Convex bodies that the robot only avoids: obstacles, and what may be where nothing was seen.
import { EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Vector3 } from 'three';
import { ConvexGeometry } from 'three/examples/jsm/geometries/ConvexGeometry.js';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { colour, onTheme } from './theme.js';

/** One mesh of all bodies, from their points in W, in the colour of that name. */
export function bodiesLayer(obstacles, name, opacity) {
  const group = new Group();
  const hulls = obstacles.map(({ points_W: points }) => new ConvexGeometry(points.map((p) => new Vector3(...p))));
  if (!hulls.length) return group;
  const geometry = mergeGeometries(hulls);
  // Pushed back a little: a body's face may lie in a surface.
  const skin = new MeshLambertMaterial({ transparent: true, opacity, depthWrite: opacity > 0.4, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  const line = new LineBasicMaterial({ transparent: true, opacity: Math.min(1, 2 * opacity) });
  onTheme(() => {
    skin.color.set(colour(name));
    line.color.set(colour(`${name}-edge`));
  });
  const mesh = new Mesh(geometry, skin);
  mesh.receiveShadow = true;
  group.fade = (hides) => { skin.opacity = hides ? 0.3 * opacity : opacity; };
  group.add(mesh, new LineSegments(new EdgesGeometry(geometry, 20), line));
  return group;
}
