// Where the student stands in a lesson of several procedures: steps seen, questions answered, and what follows of them.
import type { Course } from "./lesson";

/** What came of a question: not answered, first answer right, first answer wrong, right after a wrong one. */
export type Result = "-" | "1" | "0" | "2";

/** The same as text that a learning platform keeps until the next visit. */
export interface Kept {
  c: number; // chapter
  s: number; // step
  seen: string[]; // for each chapter a letter for each step
  a: string[]; // for each chapter a `Result` for each question
}

export class Standing {
  chapter = 0;
  step = 0;
  readonly seen: boolean[][];
  readonly results: Result[][];

  constructor(private readonly course: Course) {
    this.seen = course.chapters.map(({ part }) =>
      course.parts[part].procedures[0].steps.map(() => false),
    );
    this.results = course.chapters.map(({ questions }) => questions.map(() => "-"));
  }

  /** Marks a step as seen; whether it was not before. */
  see(step: number): boolean {
    const steps = this.seen[this.chapter];
    this.step = step;
    if (step >= steps.length || steps[step]) return false;
    return (steps[step] = true);
  }

  /** Keeps what came of an answer; only the first counts for the score. */
  answer(question: number, right: boolean): void {
    const results = this.results[this.chapter];
    if (results[question] === "-") results[question] = right ? "1" : "0";
    else if (results[question] === "0" && right) results[question] = "2";
  }

  seenSteps(chapter: number): number {
    return this.seen[chapter].filter(Boolean).length;
  }

  answered(chapter: number): number {
    return this.results[chapter].filter((each) => each !== "-").length;
  }

  rightAnswers(chapter?: number): number {
    const results = chapter === undefined ? this.results.flat() : this.results[chapter];
    return results.filter((each) => each === "1").length;
  }

  finished(chapter: number): boolean {
    return this.seen[chapter].every(Boolean) && this.results[chapter].every((each) => each !== "-");
  }

  get questions(): number {
    return this.results.flat().length;
  }

  get complete(): boolean {
    return this.course.chapters.every((_, k) => this.finished(k));
  }

  /** Share of steps and questions that are done. */
  get share(): number {
    const all = [...this.seen.flat(), ...this.results.flat().map((each) => each !== "-")];
    return all.length ? all.filter(Boolean).length / all.length : 1;
  }

  /** Percentage of right answers, or null where nothing is asked. */
  get score(): number | null {
    return this.questions ? Math.round((100 * this.rightAnswers()) / this.questions) : null;
  }

  /** Whether the lesson is passed; null where nobody fails. */
  get passed(): boolean | null {
    const { mastery } = this.course;
    return mastery === null || this.score === null ? null : (100 * this.rightAnswers()) / this.questions >= mastery;
  }

  kept(): Kept {
    const seen = this.seen.map((steps) => steps.map((each) => (each ? "1" : "0")).join(""));
    return { c: this.chapter, s: this.step, seen, a: this.results.map((each) => each.join("")) };
  }

  /** Takes up where an earlier visit ended; what does not fit this lesson is left out. */
  resume(kept: Partial<Kept> | null): void {
    if (!kept || typeof kept !== "object") return;
    this.seen.forEach((steps, k) => {
      const text = kept.seen?.[k];
      if (typeof text === "string" && text.length === steps.length) steps.forEach((_, i) => (steps[i] = text[i] === "1"));
    });
    this.results.forEach((results, k) => {
      const text = kept.a?.[k];
      if (typeof text !== "string" || text.length !== results.length) return;
      results.forEach((_, i) => (results[i] = "102".includes(text[i]) ? (text[i] as Result) : "-"));
    });
    if (Number.isInteger(kept.c) && kept.c! >= 0 && kept.c! < this.seen.length) this.chapter = kept.c!;
    if (Number.isInteger(kept.s) && kept.s! >= 0 && kept.s! < this.seen[this.chapter].length) this.step = kept.s!;
  }
}
