// The obstacles: convex bodies that the robot only avoids.
import { EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Vector3 } from 'three';
import { ConvexGeometry } from 'three/examples/jsm/geometries/ConvexGeometry.js';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { colour, onTheme } from './theme.js';

/** One mesh of all bodies, from their points in W. */
export function obstaclesLayer(obstacles) {
  const group = new Group();
  const hulls = obstacles.map(({ points_W: points }) => new ConvexGeometry(points.map((p) => new Vector3(...p))));
  if (!hulls.length) return group;
  const geometry = mergeGeometries(hulls);
  // Pushed back a little: a body's face may lie in a surface.
  const skin = new MeshLambertMaterial({ transparent: true, opacity: 0.5, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  const line = new LineBasicMaterial();
  onTheme(() => {
    skin.color.set(colour('obstacle'));
    line.color.set(colour('obstacle-edge'));
  });
  const mesh = new Mesh(geometry, skin);
  mesh.receiveShadow = true;
  group.add(mesh, new LineSegments(new EdgesGeometry(geometry, 20), line));
  return group;
}
