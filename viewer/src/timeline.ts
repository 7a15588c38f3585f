// The time of a lesson. Of one procedure it counts its frames; of two it runs through the steps that both have, so that
// both show the same step at once.
import type { Procedure } from "./lesson";

export interface Step {
  time: number;
  kind: string;
  frame: number; // of the first procedure
}

export class Timeline {
  readonly length: number;
  readonly steps: Step[];
  /** Times and, for each, the frame of every procedure. */
  private readonly knots: { time: number; frames: number[] }[];

  constructor(procedures: Procedure[]) {
    const ends = procedures.map((each) => each.times.length - 1);
    const met = procedures.length > 1 ? shared(procedures[0], procedures[1]) : [];
    const frames = [ends.map(() => 0), ...met, ends];
    const kept = frames.filter((each, k) => k === 0 || each.some((frame, p) => frame > frames[k - 1][p]));
    let time = 0;
    this.knots = kept.map((each, k) => {
      if (k) time += Math.max(...each.map((frame, p) => frame - kept[k - 1][p]));
      return { time, frames: each };
    });
    this.length = time;
    this.steps = procedures[0].steps.map(({ frame, kind }) => ({ frame, kind, time: this.timeOf(frame) }));
  }

  /** The moment of a procedure: index of a frame with a fraction. */
  frame(procedure: number, time: number): number {
    const k = Math.max(1, this.knots.findIndex((each) => each.time >= time - 1e-9));
    if (this.knots.length < 2) return 0;
    const [a, b] = [this.knots[k - 1], this.knots[k]];
    const share = b.time > a.time ? (time - a.time) / (b.time - a.time) : 0;
    return a.frames[procedure] + share * (b.frames[procedure] - a.frames[procedure]);
  }

  /** The step that a time belongs to: what is done on the way to a step's picture belongs to that step. */
  stepAt(time: number): number {
    const found = this.steps.findIndex((step) => step.time >= time - 1e-6);
    return found < 0 ? Math.max(0, this.steps.length - 1) : found;
  }

  /** The time of the step's picture before a time, or of the one after it; the ends where there is none. */
  beside(time: number, way: -1 | 1): number {
    const times = this.steps.map((step) => step.time);
    if (way > 0) return times.find((each) => each > time + 1e-6) ?? this.length;
    return times.reverse().find((each) => each < time - 1e-6) ?? 0;
  }

  private timeOf(frame: number): number {
    if (this.knots.length < 2) return 0;
    const k = Math.max(1, this.knots.findIndex((each) => each.frames[0] >= frame));
    const [a, b] = [this.knots[k - 1], this.knots[k]];
    const span = b.frames[0] - a.frames[0];
    return span ? a.time + ((frame - a.frames[0]) / span) * (b.time - a.time) : a.time;
  }
}

/** The frames of the longest row of steps that both have in this order. */
function shared(a: Procedure, b: Procedure): number[][] {
  const best: number[][][][] = Array.from({ length: a.steps.length + 1 }, () =>
    Array.from({ length: b.steps.length + 1 }, () => []),
  );
  for (let i = a.steps.length - 1; i >= 0; i--) {
    for (let j = b.steps.length - 1; j >= 0; j--) {
      const [without, other] = [best[i + 1][j], best[i][j + 1]];
      best[i][j] = without.length >= other.length ? without : other;
      if (a.steps[i].kind === b.steps[j].kind && best[i + 1][j + 1].length + 1 > best[i][j].length) {
        best[i][j] = [[a.steps[i].frame, b.steps[j].frame], ...best[i + 1][j + 1]];
      }
    }
  }
  return best[0][0];
}
