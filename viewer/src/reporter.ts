// What a lesson tells the learning platform around it.
import { H5pReporter } from "./h5p_reporter";
import type { Course } from "./lesson";
import { ScormReporter } from "./scorm_reporter";
import type { Kept, Standing } from "./standing";

export interface Answer {
  chapter: number;
  question: number;
  ask: string;
  byChoice: boolean;
  response: string; // numbers of choices with commas, or the place
  right: boolean;
}

export interface Reporter {
  /** Begins a visit; resolves with what an earlier one left. */
  begin(): Promise<Kept | null>;
  answered(answer: Answer): void;
  progress(standing: Standing): void;
}

class NoReporter implements Reporter {
  begin(): Promise<null> {
    return Promise.resolve(null);
  }

  answered(): void {}

  progress(): void {}
}

export function reporterOf(course: Course): Reporter {
  if (course.reports === "scorm") return ScormReporter.found() ?? new NoReporter();
  if (course.reports === "h5p" && window.parent !== window) return new H5pReporter();
  return new NoReporter();
}
