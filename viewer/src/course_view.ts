// A lesson of several procedures: its chapters, the panel beside the picture, and what is kept and reported.
import { Arrays, BrokenLesson, inflate } from "./arrays";
import { ChapterBar } from "./chapter_bar";
import { ChapterPanel } from "./chapter_panel";
import type { Course } from "./lesson";
import { LessonView } from "./lesson_view";
import type { Answer, Reporter } from "./reporter";
import { Standing } from "./standing";
import type { Words } from "./words";

export class CourseView {
  readonly standing: Standing;
  private readonly bar: ChapterBar;
  private readonly panel: ChapterPanel;
  private readonly hasPanel: boolean;
  private view: LessonView | null = null;
  private time = 0;

  constructor(
    private readonly course: Course,
    private readonly words: Words,
    private readonly texts: string[], // the arrays of each part
    private readonly reporter: Reporter,
  ) {
    this.standing = new Standing(course);
    this.hasPanel =
      course.chapters.length > 1 ||
      course.chapters.some(({ text, questions, hotspots }) => text.length + questions.length + hotspots.length > 0);
    this.bar = new ChapterBar(course, words, this.standing, (chapter) => void this.open(chapter, 0));
    this.panel = new ChapterPanel(course, words, this.standing, {
      answered: (answer) => this.answered(answer),
      open: (chapter) => void this.open(chapter, 0),
    });
  }

  /** Opens the lesson, where an earlier visit ended if the platform kept that. */
  async start(): Promise<void> {
    const kept = await this.reporter.begin();
    this.standing.resume(kept);
    await this.open(this.standing.chapter, kept ? this.standing.step : null);
  }

  /** Opens a chapter, at a step or at the one that its plan says; throws BrokenLesson where its arrays are damaged. */
  async open(chapter: number, step: number | null = null): Promise<void> {
    const { course } = this;
    const { part } = course.chapters[chapter];
    const { bytes, size, procedures } = course.parts[part];
    const before = this.view;
    const arrays = new Arrays(await inflate(this.texts[part], bytes, size));
    this.standing.chapter = chapter;
    this.standing.step = 0;
    this.time = -1;
    const view = new LessonView({ ...course, bytes, size, procedures }, this.words, arrays, {
      bar: this.bar.element,
      panel: this.hasPanel ? this.panel.element : null,
      chapter: course.chapters[chapter],
      optionsOpen: before ? before.optionsOpen : !this.hasPanel && window.matchMedia("(min-width: 900px)").matches,
      painted: (time, playing) => this.painted(time, playing),
      spoken: () => this.speak(),
    });
    before?.end();
    if (before) before.element.replaceWith(view.element);
    else document.body.prepend(view.element);
    this.view = view;
    this.panel.show(view, chapter);
    this.bar.element.hidden = course.chapters.length < 2;
    view.start();
    if (step !== null && step > 0) view.player.toStep(step);
    this.panel.begin(before !== null);
    Object.assign(window, { lappetLesson: { ...view.scripting(), ...this.scripting() } });
    this.told();
  }

  private scripting(): object {
    return {
      chapters: this.course.chapters.length,
      chapter: () => this.standing.chapter,
      open: (chapter: number) => this.open(chapter),
      standing: () => ({
        ...this.standing.kept(),
        score: this.standing.score,
        complete: this.standing.complete,
        passed: this.standing.passed,
      }),
    };
  }

  private speak(): void {
    this.bar.speak();
    this.panel.speak();
  }

  /** Keeps which steps were seen: those whose picture was shown, at rest or in passing. */
  private painted(time: number, playing: boolean): void {
    const { view, standing } = this;
    if (!view) return;
    const from = playing && this.time >= 0 && this.time < time ? this.time : time;
    this.time = time;
    let news = false;
    view.player.timeline.steps.forEach((step, k) => {
      if (step.time >= from - 0.5 && step.time <= time + 1e-6) news = standing.see(k) || news;
    });
    this.panel.moved();
    if (news) this.told();
  }

  private answered(answer: Answer): void {
    this.reporter.answered(answer);
    this.told();
  }

  private told(): void {
    this.bar.update();
    this.panel.update();
    this.reporter.progress(this.standing);
  }
}

/** Throws BrokenLesson where the arrays of a part are not whole. */
export function checkWhole(text: string, bytes: number): void {
  const plain = text.replace(/[\s=]+/g, "");
  const found = Math.floor((plain.length * 3) / 4);
  if (found !== bytes) throw new BrokenLesson("broken.cut", { found, expected: bytes });
}
