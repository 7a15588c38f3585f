// Keys of the whole lesson, and those that turn the picture while it has the focus.
import { VIEWS, type View } from "./camera";
import type { Picture } from "./picture";
import type { Player } from "./player";
import type { Transport } from "./transport";

const TURN = Math.PI / 24;
const ZOOM = 1.12;

export function listenToKeys(
  canvas: HTMLElement,
  player: Player,
  transport: Transport,
  picture: Picture,
  show: (view: View) => void,
  signal: AbortSignal,
): void {
  const anywhere: Record<string, () => void> = {
    ",": () => player.nudge(-1),
    ".": () => player.nudge(1),
    PageUp: () => player.skip(-1),
    PageDown: () => player.skip(1),
    "+": () => picture.zoom(1 / ZOOM),
    "=": () => picture.zoom(1 / ZOOM),
    "-": () => picture.zoom(ZOOM),
    "0": () => show("oblique"),
  };
  VIEWS.forEach((view, k) => (anywhere[String(k + 1)] = () => show(view)));
  const onPicture: Record<string, () => void> = {
    ArrowLeft: () => picture.turn(-TURN, 0),
    ArrowRight: () => picture.turn(TURN, 0),
    ArrowUp: () => picture.turn(0, -TURN),
    ArrowDown: () => picture.turn(0, TURN),
  };
  const onSlider: Record<string, () => void> = {
    ArrowLeft: () => player.nudge(-1),
    ArrowDown: () => player.nudge(-1),
    ArrowRight: () => player.nudge(1),
    ArrowUp: () => player.nudge(1),
    Home: () => player.seek(0),
    End: () => player.seek(player.timeline.length),
  };
  const press = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const on = event.target as HTMLElement;
    if (on.closest("select, textarea")) return;
    let action = on === canvas ? onPicture[event.key] : on === transport.slider ? onSlider[event.key] : undefined;
    if (!action && event.key === " " && !on.closest("button, input[type=checkbox], input[type=radio], summary")) {
      action = () => player.toggle();
    }
    action ??= anywhere[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  };
  document.addEventListener("keydown", press, { signal });
}
