// Plays a lesson: time runs on, rests at each step, and ends.
import type { Timeline } from "./timeline";

const FRAMES = 5; // a second at speed 1
const REST = 1.3; // seconds at each step

export class Player {
  time = 0;
  playing = false;
  speed = 1;
  hold = true;
  private resting = 0;

  constructor(
    readonly timeline: Timeline,
    private readonly changed: () => void,
  ) {}

  get step(): number {
    return this.timeline.stepAt(this.time);
  }

  toggle(): void {
    if (!this.playing && this.time >= this.timeline.length - 1e-6) this.time = 0;
    this.playing = !this.playing;
    this.resting = 0;
    this.changed();
  }

  pause(): void {
    this.playing = false;
    this.changed();
  }

  seek(time: number): void {
    this.time = Math.min(this.timeline.length, Math.max(0, time));
    this.resting = 0;
    this.changed();
  }

  toStep(index: number): void {
    const { steps } = this.timeline;
    this.playing = false;
    if (steps.length) this.seek(steps[Math.min(steps.length - 1, Math.max(0, index))].time);
  }

  /** To the picture of the step before, or of the next. */
  skip(way: -1 | 1): void {
    this.playing = false;
    this.seek(this.timeline.beside(this.time, way));
  }

  /** One whole frame back or on. */
  nudge(way: number): void {
    this.playing = false;
    this.seek(way > 0 ? Math.floor(this.time + 1e-6) + 1 : Math.ceil(this.time - 1e-6) - 1);
  }

  /** Lets seconds pass. */
  advance(seconds: number): void {
    if (!this.playing) return;
    if (this.resting > 0) {
      this.resting -= seconds * this.speed;
      return;
    }
    const before = this.time;
    let after = Math.min(this.timeline.length, before + seconds * FRAMES * this.speed);
    const met = this.timeline.steps.find((step) => step.time > before + 1e-6 && step.time <= after);
    if (met && this.hold) {
      after = met.time;
      this.resting = REST;
    }
    this.time = after;
    if (after >= this.timeline.length) this.playing = false;
    this.changed();
  }
}
