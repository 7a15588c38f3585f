// The panel beside the picture: a chapter's text, its hotspots, its questions, and what is left to do.
import { icon, make } from "./elements";
import { Hotspots } from "./hotspots";
import type { Course } from "./lesson";
import type { LessonView } from "./lesson_view";
import { Pointing } from "./pointing";
import { QuestionCard } from "./question_card";
import type { Answer } from "./reporter";
import type { Standing } from "./standing";
import type { Words } from "./words";

export interface PanelActions {
  answered(answer: Answer): void;
  open(chapter: number): void;
}

export class ChapterPanel {
  readonly element = make("section", { id: "chapter", tabindex: -1 });
  private heading = make("h2", { tabindex: -1 });
  private cards: QuestionCard[] = [];
  private hotspots: Hotspots | null = null;
  private pointing: Pointing | null = null;
  private readonly end = make("div", { class: "end" });
  private readonly news = make("p", { class: "spoken", role: "status" });
  private chapter = 0;
  private was = false;
  private readonly told: (() => void)[] = [];

  constructor(
    private readonly course: Course,
    private readonly words: Words,
    private readonly standing: Standing,
    private readonly actions: PanelActions,
  ) {}

  /** Fills the panel for a chapter that is shown in a view that has not begun yet. */
  show(view: LessonView, chapter: number): void {
    const { title, text, hotspots, questions } = this.course.chapters[chapter];
    this.chapter = chapter;
    this.told.length = 0;
    this.heading = make("h2", { tabindex: -1, id: "chapter-title" }, title);
    this.element.setAttribute("aria-labelledby", "chapter-title");
    const count = make("p", { class: "count" });
    this.say(() => {
      const values = { number: chapter + 1, count: this.course.chapters.length };
      count.textContent = this.words.say("chapter", values);
    });
    count.hidden = this.course.chapters.length < 2;
    const pointing = (this.pointing = new Pointing(view, this.words));
    this.hotspots = hotspots.length ? new Hotspots(hotspots, view, this.words) : null;
    this.cards = questions.map((question, k) => {
      const result = this.standing.results[chapter][k];
      return new QuestionCard(question, k, result, view, pointing, this.words, (right, response) => {
        this.standing.answer(k, right);
        this.actions.answered({
          ...{ chapter, question: k, ask: question.ask, byChoice: "choices" in question },
          ...{ response, right },
        });
      });
    });
    this.element.replaceChildren(
      count,
      this.heading,
      ...text.map((each) => make("p", { class: "text" }, each)),
      ...(this.hotspots ? [this.hotspots.list] : []),
      ...this.cards.map((card) => card.element),
      this.end,
      this.news,
    );
    this.was = this.standing.finished(chapter);
    this.news.textContent = "";
  }

  /** The view has begun: marks can be laid on its picture. */
  begin(focus: boolean): void {
    this.hotspots?.begin();
    this.speak();
    this.element.scrollTop = 0;
    if (focus) this.heading.focus({ preventScroll: true });
  }

  /** The picture has moved. */
  moved(): void {
    this.hotspots?.moved();
  }

  speak(): void {
    for (const each of this.told) each();
    this.hotspots?.speak();
    this.pointing?.speak();
    for (const card of this.cards) card.speak();
    this.update();
  }

  update(): void {
    const { standing, words, chapter, course } = this;
    const lines: (Node | string)[] = [];
    const add = (done: number, count: number, key: string): void => {
      if (!count) return;
      const mark = make("span", { class: done === count ? "mark full" : "mark" }, ...(done === count ? [icon("check")] : []));
      lines.push(make("li", {}, mark, make("span", {}, words.say(key, { done, count }))));
    };
    add(standing.seenSteps(chapter), standing.seen[chapter].length, "done.steps");
    add(standing.answered(chapter), standing.results[chapter].length, "done.questions");
    const finished = standing.finished(chapter);
    const parts: Node[] = [];
    const said = standing.complete ? words.say("lesson.done") : finished ? words.say("chapter.finished") : "";
    if (said) parts.push(make("h3", {}, said));
    if (!standing.complete) parts.push(make("ul", { class: "todo" }, ...lines));
    else parts.push(...this.results());
    const next = course.chapters.findIndex((_, k) => k > chapter && !standing.finished(k));
    const other = next >= 0 ? next : course.chapters.findIndex((_, k) => k !== chapter && !standing.finished(k));
    if (other >= 0) {
      const label = words.say(other > chapter ? "chapter.next" : "chapter.back", { title: course.chapters[other].title });
      const button = make("button", { type: "button", class: finished ? "primary" : "", id: "next-chapter" }, label);
      button.addEventListener("click", () => this.actions.open(other));
      parts.push(button);
    }
    const focused = document.activeElement?.id === "next-chapter";
    this.end.classList.toggle("finished", finished);
    this.end.replaceChildren(...parts);
    if (focused) document.getElementById("next-chapter")?.focus();
    if (finished && !this.was) this.news.textContent = said;
    this.was = finished;
  }

  /** What came of the whole lesson. */
  private results(): Node[] {
    const { standing, words, course } = this;
    if (!standing.questions) return [];
    const values = { right: standing.rightAnswers(), count: standing.questions, percent: standing.score ?? 0 };
    const { passed } = standing;
    const judged = passed === null ? [] : [make("p", {}, words.say(passed ? "passed" : "failed", { pass: course.mastery ?? 0 }))];
    return [make("p", { class: "sum" }, words.say("sum", values)), ...judged];
  }

  private say(how: () => void): void {
    this.told.push(how);
  }
}
