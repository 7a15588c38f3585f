// One procedure on the screen: its tissue, what lies on and around it, its lights. Coordinates are those of the
// surgical field: right, up along the skin, out of it; the field's middle is the origin.
import * as THREE from "three";
import type { Arrays, Positions } from "./arrays";
import type { Lesson, Procedure, Vector } from "./lesson";
import { Materials, type Look, sceneryMaterial, strandMaterial } from "./materials";
import { SkinMesh, writeNormals } from "./skin_mesh";
import { strandLines } from "./strand_lines";
import { between, type Line, Tubes } from "./tubes";

const VESSELS = ["artery", "vein", "nerve", "lymphatic"];
const LIP_RADIUS = 0.1;

export interface Shown {
  look: Look;
  hooks: boolean;
  threads: boolean;
  marks: boolean;
  letters: boolean;
  landmarks: boolean;
  around: boolean;
  vessels: boolean;
}

interface StrandSet {
  frames: Line[][];
  tubes: Tubes;
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly radius: number;
  readonly epochs: SkinMesh[];
  readonly hasVessels: boolean;
  readonly hasBody: boolean;
  private readonly tissue = new THREE.Group();
  private readonly around = new THREE.Group();
  private readonly bodies: THREE.Mesh[] = [];
  private readonly materials: Materials;
  private readonly strands = new Map<string, StrandSet>();
  private readonly lips: Tubes;
  private readonly place: { epoch: SkinMesh; local: number }[] = [];
  private bed: { mesh: THREE.Mesh; positions: Positions; index: Uint32Array } | null = null;
  private moment = "";
  private key!: THREE.DirectionalLight;
  private stale = true; // whether the shadow is that of another moment
  private waited = Infinity; // pictures since it was cast
  private opacity = 1;
  private readonly ray = new THREE.Raycaster();

  constructor(
    lesson: Lesson,
    readonly procedure: Procedure,
    arrays: Arrays,
    shadowPixels: number,
  ) {
    const { field } = procedure;
    this.materials = new Materials(lesson, procedure.layers);
    const axes = new THREE.Matrix4().makeBasis(vector(field.right), vector(field.up), vector(field.normal)).transpose();
    this.tissue.applyMatrix4(axes.multiply(new THREE.Matrix4().makeTranslation(vector(field.center).negate())));
    this.scene.add(this.tissue);
    this.tissue.updateMatrixWorld(true);
    this.radius = Math.max(...field.points.map((each) => vector(each).distanceTo(vector(field.center)))) + 6;
    this.epochs = procedure.epochs.map((epoch) => new SkinMesh(epoch, arrays, this.materials));
    for (const skin of this.epochs) {
      this.tissue.add(skin.mesh);
      skin.epoch.frames.forEach((frame, local) => {
        this.place[frame] = { epoch: skin, local };
      });
    }
    for (const [name, strands] of Object.entries(procedure.strands)) {
      const tubes = new Tubes(strandMaterial(name, strands.color), name === "hooks" ? 12 : 8);
      this.tissue.add(tubes.mesh);
      this.strands.set(name, { frames: strandLines(strands, arrays), tubes });
    }
    this.lips = new Tubes(strandMaterial("lips"), 5);
    this.tissue.add(this.lips.mesh);
    this.addBed(arrays);
    this.addScenery(arrays);
    this.hasVessels = VESSELS.some((kind) => this.strands.has(kind));
    this.hasBody = this.around.children.length > 0;
    this.addLights(shadowPixels);
  }

  /** The point of the field's coordinates that a place in mm is. */
  placed(place: Vector): THREE.Vector3 {
    return vector(place).applyMatrix4(this.tissue.matrixWorld);
  }

  /** What a matrix of the field's coordinates is in those of the cache, in mm. */
  inTissue(matrix: THREE.Matrix4): THREE.Matrix4 {
    return this.tissue.matrixWorld.clone().invert().multiply(matrix);
  }

  /** Shows a moment: a frame's index and how far on the way to the next. */
  show(time: number, shown: Shown): void {
    const last = this.procedure.times.length - 1;
    const frame = Math.min(last, Math.max(0, Math.floor(time + 1e-6)));
    const here = this.place[frame];
    const there = frame < last ? this.place[frame + 1] : here;
    const moves = there.epoch === here.epoch && there !== here;
    const share = moves ? Math.min(1, Math.max(0, time - frame)) : 0;
    const next = moves ? there.local : here.local;
    const mapped = shown.look === "painted" || shown.look === "grid" ? null : shown.look;
    for (const skin of this.epochs) skin.mesh.visible = skin === here.epoch;
    here.epoch.show(here.local, next, share, mapped);
    this.materials.setLook(shown.look);
    const opacity = shown.vessels && this.hasVessels ? 0.4 : 1;
    if (opacity !== this.opacity) {
      this.materials.setOpacity((this.opacity = opacity));
      for (const skin of this.epochs) skin.mesh.castShadow = opacity >= 1;
      this.stale = true;
    }
    const moment = `${frame} ${share}`;
    if (moment !== this.moment) {
      this.moment = moment;
      this.stale = true;
      const to = moves ? frame + 1 : frame;
      for (const { frames, tubes } of this.strands.values()) tubes.draw(between(frames[frame], frames[to], share));
      this.drawLips(here.epoch);
      this.drawBed(frame, to, share);
    }
    for (const [name, { tubes }] of this.strands) {
      const wanted = VESSELS.includes(name) ? true : shown[name as "hooks" | "threads" | "marks"];
      const visible = wanted && tubes.mesh.geometry.attributes.position.count > 0;
      if (visible !== tubes.mesh.visible) this.stale = true;
      tubes.mesh.visible = visible;
    }
    this.around.visible = shown.around;
  }

  /** Draws surfaces without relief and gloss, or with them. */
  drawQuickly(quick: boolean): void {
    const surfaces = quick ? this.materials.quick : this.materials.fine;
    for (const skin of this.epochs) skin.mesh.material = surfaces.tissue;
    for (const body of this.bodies) body.material = surfaces.body;
    if (this.bed) this.bed.mesh.material = surfaces.bed;
  }

  /** Lets the shadow follow what is shown, in every picture or in every so-and-so-many-th. */
  castShadow(every: number): void {
    this.waited++;
    if (!this.stale || this.waited < every) return;
    this.key.shadow.needsUpdate = true;
    this.stale = false;
    this.waited = 0;
  }

  /** Positions of the cache's vertices that are on the screen now, in mm. */
  points(): Float32Array {
    return this.epochs.find((skin) => skin.mesh.visible)!.points;
  }

  /** Whether a place of the field's coordinates is not hidden from a camera by skin. */
  seen(place: THREE.Vector3, camera: THREE.Camera): boolean {
    const skin = this.epochs.find((each) => each.mesh.visible);
    if (!skin) return true;
    const from = camera.getWorldPosition(new THREE.Vector3());
    const way = place.clone().sub(from);
    const far = way.length();
    this.ray.set(from, way.divideScalar(far));
    this.ray.far = far - 1;
    return this.ray.intersectObject(skin.mesh, false).length === 0;
  }

  /** The place of the skin that a ray through a point of the screen (-1 to 1) meets first, in the field's coordinates. */
  touched(point: THREE.Vector2, camera: THREE.Camera): THREE.Vector3 | null {
    const skin = this.epochs.find((each) => each.mesh.visible);
    if (!skin) return null;
    this.ray.setFromCamera(point, camera);
    this.ray.far = Infinity;
    return this.ray.intersectObject(skin.mesh, false)[0]?.point ?? null;
  }

  private drawLips(skin: SkinMesh): void {
    const radius = LIP_RADIUS * this.procedure.field.scale;
    this.lips.draw(
      skin.lips.map((chain) => {
        const points = new Float32Array(3 * chain.length);
        chain.forEach((vertex, k) => points.set(skin.points.subarray(3 * vertex, 3 * vertex + 3), 3 * k));
        return { points, radii: new Float32Array(chain.length).fill(radius) };
      }),
    );
  }

  private addBed(arrays: Arrays): void {
    const { bed } = this.procedure;
    if (!bed) return;
    const positions = arrays.positions(bed.positions);
    const index = arrays.numbers(bed.triangles) as Uint32Array;
    const mesh = plainMesh(positions, index, this.materials.fine.bed);
    mesh.receiveShadow = true;
    this.tissue.add(mesh);
    this.bed = { mesh, positions, index };
  }

  private drawBed(frame: number, next: number, share: number): void {
    if (!this.bed) return;
    const { position, normal } = this.bed.mesh.geometry.attributes as Record<string, THREE.BufferAttribute>;
    this.bed.positions.write(position.array as Float32Array, frame, next, share);
    writeNormals(this.bed.index, position.array as Float32Array, normal.array as Float32Array);
    position.needsUpdate = normal.needsUpdate = true;
  }

  private addScenery(arrays: Arrays): void {
    for (const { kind, positions, triangles } of this.procedure.scenery) {
      const own = sceneryMaterial(kind);
      const material = own ?? this.materials.fine.body;
      const mesh = plainMesh(arrays.positions(positions), arrays.numbers(triangles) as Uint32Array, material);
      mesh.receiveShadow = true;
      this.around.add(mesh);
      if (!own) this.bodies.push(mesh);
    }
    this.tissue.add(this.around);
  }

  private addLights(shadowPixels: number): void {
    const reach = 4 * this.radius * this.procedure.field.context;
    this.scene.add(new THREE.HemisphereLight(0xf4f8ff, 0xd8b9a6, 1.15));
    const light = (x: number, y: number, z: number, power: number): THREE.DirectionalLight => {
      const made = new THREE.DirectionalLight(0xffffff, power);
      made.position.set(x, y, z).setLength(reach);
      this.scene.add(made);
      return made;
    };
    const key = light(-0.85, 0.55, 1.0, 2.3);
    light(1, -0.5, 0.8, 0.65);
    light(0.35, 1.2, 0.5, 0.7);
    this.key = key;
    key.castShadow = true;
    key.shadow.autoUpdate = false; // only what moves casts another shadow
    key.shadow.mapSize.set(shadowPixels, shadowPixels);
    const half = 1.35 * this.radius;
    Object.assign(key.shadow.camera, { left: -half, right: half, top: half, bottom: -half, near: 0.1 * reach, far: 2 * reach });
    key.shadow.normalBias = 0.35;
    key.shadow.bias = -0.0004;
    key.shadow.radius = 5;
  }
}

function vector(from: Vector): THREE.Vector3 {
  return new THREE.Vector3(...from);
}

/** A mesh of one label; its noise rides on its first state. */
function plainMesh(positions: Positions, index: Uint32Array, material: THREE.Material): THREE.Mesh {
  const at = new Float32Array(3 * positions.places);
  const normal = new Float32Array(at.length);
  positions.write(at, 0);
  writeNormals(index, at, normal);
  const geometry = new THREE.BufferGeometry();
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  geometry.setAttribute("position", new THREE.BufferAttribute(at, 3).setUsage(THREE.DynamicDrawUsage));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  geometry.setAttribute("rest", new THREE.BufferAttribute(at.slice(), 3));
  for (const [name, size] of [["grid", 2], ["depth", 1], ["row", 1], ["quantity", 1]] as const) {
    geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(size * positions.places), size));
  }
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}
