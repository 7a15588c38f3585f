// Where the camera stands, in the field's coordinates: the views of the plates, and ways from one to another.
import * as THREE from "three";
import type { Stage } from "./stage";

export type View = "oblique" | "top" | "low" | "behind";
export const VIEWS: View[] = ["oblique", "top", "low", "behind"];

const ELEVATION: Record<View, number> = { oblique: 50, top: 90, low: 26, behind: 50 };
const TURN = 9;
const LEANING = 0.4; // of the angle to the normal, where a body is shown
const OVERHANG = -0.2;
const FILL = 0.88; // of the picture that the field takes up
const LENS = 22.6; // degrees that the longer side of the picture spans

export interface Pose {
  position: THREE.Vector3;
  target: THREE.Vector3;
}

/** Which way is up for turning the picture: out of the skin, or the body's up where a body is shown. */
export function upright(stage: Stage): THREE.Vector3 {
  return stage.hasBody ? new THREE.Vector3(0, 1, 0) : new THREE.Vector3(0, 0, 1);
}

/** Sets the angle of the lens for a picture of some shape. */
export function setLens(camera: THREE.PerspectiveCamera, aspect: number): void {
  camera.aspect = aspect;
  const across = Math.tan(THREE.MathUtils.degToRad(LENS / 2));
  camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(aspect > 1 ? across / aspect : across));
  camera.updateProjectionMatrix();
}

/** The nearest pose in a view's direction that holds the fields of all stages. */
export function viewPose(view: View, stages: Stage[], camera: THREE.PerspectiveCamera): Pose {
  const body = stages.some((stage) => stage.hasBody);
  const steep = body ? 90 - LEANING * (90 - ELEVATION[view]) : ELEVATION[view];
  const elevation = THREE.MathUtils.degToRad(Math.min(89.9, steep));
  const turn = THREE.MathUtils.degToRad(view === "top" ? 0 : TURN);
  const overhang = body && stages[0].procedure.field.normal[2] < OVERHANG;
  const side = (overhang ? 1 : -1) * (view === "behind" ? -1 : 1);
  const back = new THREE.Vector3(
    Math.cos(elevation) * Math.sin(turn),
    Math.cos(elevation) * side * Math.cos(turn),
    Math.sin(elevation),
  ).normalize();
  const up = upright(stages[0]);
  const right = new THREE.Vector3().crossVectors(up, back).normalize();
  const above = new THREE.Vector3().crossVectors(back, right);
  const context = body ? Math.min(2.2, stages[0].procedure.field.context) : 1;
  const half = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
  const room = [half * camera.aspect * (FILL / context), half * (FILL / context)];
  const local = stages.flatMap((stage) =>
    stage.procedure.field.points.map((each) => {
      const place = stage.placed(each);
      return [place.dot(right), place.dot(above), place.dot(back)];
    }),
  );
  const shift = [0, 0];
  let distance = 0;
  for (let round = 0; round < 12; round++) {
    distance = Math.max(...local.map((p) => Math.max(...[0, 1].map((k) => Math.abs(p[k] - shift[k]) / room[k])) + p[2]));
    for (const k of [0, 1]) {
      const seen = local.map((p) => (p[k] - shift[k]) / (distance - p[2]));
      shift[k] += 0.5 * (Math.min(...seen) + Math.max(...seen)) * distance;
    }
  }
  const target = right.multiplyScalar(shift[0]).addScaledVector(above, shift[1]);
  return { target, position: target.clone().addScaledVector(back, distance) };
}

/** Between two poses: the way around the target, not through it. */
export function blend(a: Pose, b: Pose, share: number): Pose {
  const target = a.target.clone().lerp(b.target, share);
  const from = a.position.clone().sub(a.target);
  const to = b.position.clone().sub(b.target);
  const length = from.length() * (1 - share) + to.length() * share;
  const turn = new THREE.Quaternion().setFromUnitVectors(from.clone().normalize(), to.clone().normalize());
  const way = from.normalize().applyQuaternion(new THREE.Quaternion().slerp(turn, share));
  return { target, position: target.clone().addScaledVector(way, length) };
}
