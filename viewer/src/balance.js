// Centre of mass, its plumb line and the support region, and the way of the CoM through the plan.
import {
  CanvasTexture, CircleGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, SRGBColorSpace, Sprite,
  SpriteMaterial,
} from 'three';
import { dispose } from './contacts.js';
import { lineMaterial, ring, segments } from './line.js';
import { fan } from './surfaces.js';
import { colour, onTheme } from './theme.js';

const SYMBOL_PX = 64;

/** The drawing-board symbol of a centre of mass: a disc in four quarters. */
function symbol() {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = SYMBOL_PX;
  const pen = canvas.getContext('2d');
  const [c, r] = [SYMBOL_PX / 2, SYMBOL_PX / 2 - 4];
  for (let quarter = 0; quarter < 4; quarter++) {
    pen.beginPath();
    pen.moveTo(c, c);
    pen.arc(c, c, r, (quarter * Math.PI) / 2, ((quarter + 1) * Math.PI) / 2);
    pen.fillStyle = quarter % 2 ? '#fde047' : '#111827';
    pen.fill();
  }
  pen.beginPath();
  pen.arc(c, c, r, 0, 2 * Math.PI);
  pen.lineWidth = 5;
  pen.strokeStyle = '#111827';
  pen.stroke();
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

export class BalanceLayer {
  constructor(stage, stances) {
    this.group = new Group();
    this.region = new Group();
    this.mark = new Sprite(new SpriteMaterial({ map: symbol(), depthTest: false, sizeAttenuation: false }));
    this.mark.scale.setScalar(0.017);
    this.mark.renderOrder = 30;
    this.foot = new Mesh(new CircleGeometry(0.014, 24), new MeshBasicMaterial({ depthTest: false, transparent: true }));
    this.foot.renderOrder = 24;
    this.fill = new MeshBasicMaterial({
      transparent: true, opacity: 0.16, side: DoubleSide, depthTest: false, depthWrite: false,
    });
    onTheme(() => {
      this.fill.color.set(colour('support'));
      this.foot.material.color.set(colour('com'));
    });
    const over = { depthTest: false, transparent: true };
    this.lines = {
      edge: lineMaterial(stage, 'support', { linewidth: 2.4, ...over }),
      kept: lineMaterial(stage, 'support', { linewidth: 1.4, dashed: true, dashSize: 0.012, gapSize: 0.009, ...over }),
      plumb: lineMaterial(stage, 'com', { linewidth: 1.6, dashed: true, dashSize: 0.025, gapSize: 0.018, ...over }),
    };
    this.group.add(this.region, this.mark, this.foot);
    this.path = new Group();
    const way = stances.slice(1).flatMap((stance, i) => [...stances[i].com_W, ...stance.com_W]);
    if (way.length) this.path.add(segments(way, lineMaterial(stage, 'com', { linewidth: 1.6, transparent: true, opacity: 0.8 })));
  }

  /** Of an instant between stances, `level` is that of the stance it leads to, and there is no region. */
  show(stance, ground = stance.support_level_m) {
    dispose(this.region);
    const [x, y, z] = stance.com_W;
    const level = ground + 0.002;
    this.mark.position.set(x, y, z);
    this.foot.position.set(x, y, level);
    const parts = [segments([x, y, z, x, y, level], this.lines.plumb)];
    if (stance.support) {
      const at = (polygon) => polygon.map(([px, py]) => [px, py, level]);
      const face = new Mesh(fan(at(stance.support.region)), this.fill);
      face.renderOrder = 21;
      parts.push(face, segments(ring(at(stance.support.region)), this.lines.edge));
      if (stance.support.kept) parts.push(segments(ring(at(stance.support.kept)), this.lines.kept));
    }
    for (const part of parts) part.renderOrder ||= 22;
    this.region.add(...parts);
  }
}
