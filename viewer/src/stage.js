// The canvas: renderer, lights, ground grid, controls and the labels over it. Draws on demand.
import {
  Color, DirectionalLight, GridHelper, HemisphereLight, PerspectiveCamera, Scene,
  WebGLRenderer, PCFShadowMap,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { CSS2DRenderer } from 'three/examples/jsm/renderers/CSS2DRenderer.js';
import { colour, isDark, onTheme } from './theme.js';

export class Stage {
  /** `bounds` is the box of what matters in W, z up. */
  constructor(element, canvas, labels, bounds) {
    this.element = element;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.05, 200);
    this.camera.up.set(0, 0, 1);
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.labels = new CSS2DRenderer({ element: labels });
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 0.2;
    this.controls.maxDistance = 60;
    this.controls.addEventListener('change', () => this.invalidate());
    this.resizeListeners = [];
    this.lineMaterials = new Set();
    this.pending = false;
    this.reserved = 0;
    this.beforeDraw = [];
    this.afterDraw = [];
    this.addLights(bounds);
    this.addGround(bounds);
    onTheme(() => this.invalidate());
    this.resize();
    new ResizeObserver(() => {
      // Drawn at once: a new size empties the canvas, and the browser is about to show it.
      if (this.resize()) this.draw();
    }).observe(element);
  }

  addLights(bounds) {
    const sky = new HemisphereLight(0xffffff, 0x8a94a0, 1.5);
    sky.position.set(0, 0, 1);
    const sun = new DirectionalLight(0xffffff, 1.9);
    const { centre, radius } = bounds;
    sun.position.set(centre.x - 0.35 * radius, centre.y - 0.6 * radius, centre.z + 2.2 * radius);
    sun.target.position.copy(centre);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.radius = 4;
    sun.shadow.bias = -0.0005;
    sun.shadow.normalBias = 0.01;
    Object.assign(sun.shadow.camera, {
      left: -radius, right: radius, top: radius, bottom: -radius, near: 0.1, far: 5 * radius,
    });
    // A weak light at the camera, so that no side is black.
    const lamp = new DirectionalLight(0xffffff, 0.7);
    this.camera.add(lamp, lamp.target);
    lamp.target.position.set(0, 0, -1);
    this.scene.add(sky, sun, sun.target, this.camera);
    onTheme(() => {
      sky.groundColor = new Color(isDark() ? 0x3a424c : 0x9aa4b0);
      sky.intensity = isDark() ? 1.15 : 1.5;
      sun.intensity = isDark() ? 1.5 : 1.9;
    });
  }

  /** A grid of half metres just under the lowest surface. */
  addGround(bounds) {
    const size = 2 * Math.ceil(bounds.radius + 1.5);
    this.grid = null;
    onTheme(() => {
      if (this.grid) {
        this.scene.remove(this.grid);
        this.grid.dispose();
      }
      this.grid = new GridHelper(size, 2 * size, colour('grid-strong'), colour('grid'));
      this.grid.rotation.x = Math.PI / 2;
      this.grid.position.set(Math.round(bounds.centre.x), Math.round(bounds.centre.y), bounds.floor - 0.004);
      this.scene.add(this.grid);
      this.scene.background = new Color(colour('stage'));
    });
  }

  /** Fat lines need the size of the canvas. */
  adoptLine(material) {
    this.lineMaterials.add(material);
    material.resolution.set(this.width, this.height);
    return material;
  }

  /** Keeps the right edge free of what a view fits: `pixels` of it are covered. */
  reserve(pixels) {
    this.reserved = pixels;
    this.project();
    for (const listener of this.resizeListeners) listener();
    this.invalidate();
  }

  /** The camera's picture is that of the free part, continued under the covered one. */
  project() {
    const free = Math.max(0.5 * this.width, this.width - this.reserved);
    this.camera.aspect = free / this.height;
    this.camera.setViewOffset(free, this.height, 0, 0, this.width, this.height);
  }

  /** Takes the size of the element; false when it has that size. */
  resize() {
    const [width, height] = [Math.max(1, this.element.clientWidth), Math.max(1, this.element.clientHeight)];
    if (width === this.width && height === this.height) return false;
    Object.assign(this, { width, height });
    this.project();
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(this.width, this.height, false);
    this.labels.setSize(this.width, this.height);
    for (const material of this.lineMaterials) material.resolution.set(this.width, this.height);
    for (const listener of this.resizeListeners) listener();
    return true;
  }

  /** Draws once, in the browser's next frame. */
  invalidate() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  draw() {
    for (const listener of this.beforeDraw) listener();
    this.renderer.render(this.scene, this.camera);
    this.labels.render(this.scene, this.camera);
    for (const listener of this.afterDraw) listener();
  }
}
