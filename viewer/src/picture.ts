// The picture: one canvas, a part of it for each procedure, one camera for all.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { blend, type Pose, setLens, upright, type View, viewPose } from "./camera";
import { Labels } from "./labels";
import { drawsInSoftware } from "./software";
import type { Shown, Stage } from "./stage";
import type { Timeline } from "./timeline";

const FLIGHT = 0.7; // seconds from one view to another
const SLOW = 45; // milliseconds from picture to picture: slower ones have fewer pixels while they move
const QUICK = 0.4; // of that: quicker ones have more
// Pictures in a row that are slow or quick before their pixels change: that stops what draws until all is drawn.
const FEW = 2;
const MANY = 30;
const COARSER = 0.75;
const FINER = 1.2;
const SHADOW_EVERY = 4; // pictures, while one moves that the processor draws: its shadow is half of the work
const REST = 250; // milliseconds after which a picture rests
const APART = 1000; // pictures that follow each other sooner are of one motion, be they as slow as they may
const COARSEST = 0.5;
const FINEST = 1.5; // of a resting picture without smoothed edges

export class Picture {
  readonly camera = new THREE.PerspectiveCamera(20, 1, 1, 10000);
  private readonly software = drawsInSoftware();
  private readonly renderer: THREE.WebGLRenderer;
  private readonly controls: OrbitControls;
  readonly labels: Labels;
  private readonly sized: ResizeObserver;
  private flight: { from: Pose; to: Pose; at: number } | null = null;
  private sharp = 1; // share of the screen's pixels along an edge
  private readonly rested: number; // that of a picture that rests
  private moved = 1; // that of one that moves
  private slow = 0; // pictures in a row that were
  private quick = 0;
  private drawn = 0;
  private settle = 0;
  private settled = false;
  private view: View | null = "oblique";

  constructor(
    private readonly canvas: HTMLCanvasElement,
    overlay: HTMLElement,
    readonly stages: Stage[],
    private readonly timeline: Timeline,
    private readonly still: boolean,
    private readonly requestDraw: () => void,
  ) {
    const { software } = this;
    this.rested = software ? FINEST : 1;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !software, alpha: true, preserveDrawingBuffer: true });
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.toneMappingExposure = 1.02;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = software ? THREE.BasicShadowMap : THREE.PCFShadowMap;
    this.renderer.autoClear = false;
    this.camera.up.copy(upright(stages[0]));
    this.camera.position.set(0, -100, 100); // in its own target the controls would begin with NaN, and keep it
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !still;
    this.controls.dampingFactor = 0.12;
    this.controls.zoomToCursor = stages.length === 1;
    const reach = Math.max(...stages.map((stage) => stage.radius * stage.procedure.field.context));
    this.controls.minDistance = 0.2 * reach;
    this.controls.maxDistance = 40 * reach;
    this.controls.addEventListener("start", () => {
      this.flight = null;
      this.view = null;
    });
    this.controls.addEventListener("change", requestDraw);
    this.labels = new Labels(overlay, stages, requestDraw);
    this.sized = new ResizeObserver(() => this.resize());
    this.sized.observe(canvas.parentElement!);
    this.resize();
  }

  get currentView(): View | null {
    return this.view;
  }

  /** Whether nothing moves, and the picture has all its pixels. */
  get resting(): boolean {
    return !this.flight && this.sharp === this.rested;
  }

  show(view: View, at = false): void {
    this.view = view;
    const to = viewPose(view, this.stages, this.camera);
    if (at || this.still) {
      this.flight = null;
      this.stand(to);
    } else {
      const from = { position: this.camera.position.clone(), target: this.controls.target.clone() };
      this.flight = { from, to, at: performance.now() };
    }
    this.requestDraw();
  }

  /** Turns the camera around what it looks at, in radians. */
  turn(across: number, over: number): void {
    const up = this.camera.up;
    const way = this.camera.position.clone().sub(this.controls.target);
    const side = new THREE.Vector3().crossVectors(up, way).normalize();
    const angle = way.angleTo(up);
    const limited = Math.min(Math.PI - 0.02, Math.max(0.02, angle + over)) - angle;
    way.applyAxisAngle(side, limited).applyAxisAngle(up, across);
    this.standAt(way);
  }

  zoom(factor: number): void {
    const way = this.camera.position.clone().sub(this.controls.target);
    const far = THREE.MathUtils.clamp(way.length() * factor, this.controls.minDistance, this.controls.maxDistance);
    this.standAt(way.setLength(far));
  }

  /** Draws; playing: whether another moment follows. True while the camera is still moving by itself. */
  draw(time: number, shown: Shown, playing: boolean): boolean {
    let moving = this.fly();
    moving = this.controls.update() || moving;
    this.adapt(moving || playing);
    this.near();
    const parts = this.parts();
    this.renderer.setScissorTest(false);
    this.renderer.clear();
    this.renderer.setScissorTest(true);
    this.stages.forEach((stage, k) => {
      const moment = this.timeline.frame(k, time);
      stage.show(this.still ? Math.floor(moment + 1e-6) : moment, shown);
      stage.drawQuickly(this.software && !this.resting);
      stage.castShadow(this.software && !this.resting ? SHADOW_EVERY : 1);
      this.drawPart(stage, parts[k]);
      this.labels.place(stage, moment, this.camera, parts[k], shown);
    });
    return moving;
  }

  /** The place of the skin at a point of the canvas (CSS pixels), in the field's coordinates of its stage. */
  pick(x: number, y: number): { stage: Stage; place: THREE.Vector3 } | null {
    const parts = this.parts();
    const which = parts.findIndex((part) => x >= part.x && x < part.right && y >= part.y && y < part.bottom);
    if (which < 0) return null;
    const part = parts[which];
    const on = new THREE.Vector2((2 * (x - part.x)) / part.width - 1, 1 - (2 * (y - part.y)) / part.height);
    const place = this.stages[which].touched(on, this.camera);
    return place && { stage: this.stages[which], place };
  }

  /** Where a place of a stage is on the page, in CSS pixels. */
  onScreen(place: THREE.Vector3, stage: number): [number, number] {
    const part = this.parts()[stage];
    const box = this.canvas.getBoundingClientRect();
    const on = place.clone().project(this.camera);
    return [box.x + part.x + (0.5 + 0.5 * on.x) * part.width, box.y + part.y + (0.5 - 0.5 * on.y) * part.height];
  }

  /** The camera as the tissue of a stage has it: a matrix of four columns, in mm, and the angle from top to bottom. */
  seenFrom(stage: Stage): { matrix: number[]; angle: number } {
    this.camera.updateMatrixWorld();
    return { matrix: stage.inTissue(this.camera.matrixWorld).toArray(), angle: this.camera.fov };
  }

  /** Ends the picture; nothing of it may be used afterwards. */
  dispose(): void {
    clearTimeout(this.settle);
    this.sized.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  /** A picture of a moment as a data address, with the camera where it is. */
  still_image(time: number, shown: Shown, width: number, height: number, stage: number): string {
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = height;
    const target = this.stages[stage];
    const size = this.renderer.getSize(new THREE.Vector2());
    const ratio = this.renderer.getPixelRatio();
    target.show(Math.floor(this.timeline.frame(stage, time) + 1e-6), shown);
    target.drawQuickly(false);
    target.castShadow(1);
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, width, height);
    setLens(this.camera, width / height);
    this.renderer.clear();
    this.renderer.render(target.scene, this.camera);
    canvas.getContext("2d")!.drawImage(this.renderer.domElement, 0, 0, width, height);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(size.x, size.y, false);
    this.resize();
    return canvas.toDataURL("image/png");
  }

  private standAt(way: THREE.Vector3): void {
    this.view = null;
    this.flight = null;
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
    this.requestDraw();
  }

  private stand(pose: Pose): void {
    this.camera.position.copy(pose.position);
    this.controls.target.copy(pose.target);
    this.controls.update();
  }

  private fly(): boolean {
    if (!this.flight) return false;
    const share = Math.min(1, (performance.now() - this.flight.at) / (1000 * FLIGHT));
    this.stand(blend(this.flight.from, this.flight.to, share * share * (3 - 2 * share)));
    if (share >= 1) this.flight = null;
    return share < 1;
  }

  /** Near and far planes around what there is. */
  private near(): void {
    const far = this.camera.position.length();
    const reach = Math.max(...this.stages.map((stage) => stage.radius * stage.procedure.field.context * 8)) + 150;
    this.camera.near = Math.max(0.01 * far, far - reach);
    this.camera.far = far + reach;
    this.camera.updateProjectionMatrix();
  }

  private drawPart(stage: Stage, part: DOMRect): void {
    const { renderer, camera } = this;
    const bottom = this.canvas.clientHeight - part.y - part.height;
    renderer.setViewport(part.x, bottom, part.width, part.height);
    renderer.setScissor(part.x, bottom, part.width, part.height);
    renderer.render(stage.scene, camera);
  }

  /** The parts of the canvas in CSS pixels: beside each other where it is wide, below each other where it is high. */
  private parts(): DOMRect[] {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (this.stages.length === 1) return [new DOMRect(0, 0, width, height)];
    if (width >= height) return [new DOMRect(0, 0, width / 2, height), new DOMRect(width / 2, 0, width / 2, height)];
    return [new DOMRect(0, 0, width, height / 2), new DOMRect(0, height / 2, width, height / 2)];
  }

  private resize(): void {
    const frame = this.canvas.parentElement!;
    const [width, height] = [frame.clientWidth, frame.clientHeight];
    if (width < 2 || height < 2) return; // not laid out yet: a camera without a shape would keep NaN
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1) * this.sharp);
    this.renderer.setSize(width, height, false);
    frame.querySelector(".titles")?.classList.toggle("high", width < height); // as `parts`
    const [part] = this.parts();
    setLens(this.camera, part.width / part.height);
    if (this.view) this.stand(viewPose(this.view, this.stages, this.camera));
    this.requestDraw();
  }

  /** Fewer pixels while a slow picture moves, all of them when it rests. */
  private adapt(moving: boolean): void {
    const gap = performance.now() - this.drawn;
    this.drawn += gap;
    clearTimeout(this.settle);
    const { settled } = this;
    this.settled = false;
    if (moving || (gap < APART && !settled)) {
      if (this.sharp === this.moved && gap < 1500) {
        this.slow = gap > SLOW ? this.slow + 1 : 0;
        this.quick = gap < QUICK * SLOW ? this.quick + 1 : 0;
        if (this.slow >= FEW) this.change(COARSER);
        else if (this.quick >= MANY) this.change(FINER);
      }
      this.setSharp(this.moved);
    }
    if (moving) return;
    this.settle = window.setTimeout(() => {
      if (this.sharp === this.rested) return;
      this.setSharp(this.rested);
      this.settled = true; // what is drawn next is this picture with all its pixels
      this.requestDraw();
    }, REST);
  }

  private change(times: number): void {
    this.moved = Math.min(1, Math.max(COARSEST, times * this.moved));
    this.slow = this.quick = 0;
  }

  private setSharp(sharp: number): void {
    if (sharp === this.sharp) return;
    this.sharp = sharp;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1) * sharp);
  }
}
