// A question in the panel: choices, or a place to point at. One may try again; the first answer counts.
import type * as THREE from "three";
import { icon, make } from "./elements";
import type { ChoiceQuestion, PlaceQuestion, Question } from "./lesson";
import type { LessonView } from "./lesson_view";
import { distance, namesOf } from "./places";
import type { Pointing } from "./pointing";
import type { Result } from "./standing";
import type { Words } from "./words";

export class QuestionCard {
  readonly element: HTMLElement;
  private readonly label = make("span", { class: "kind" });
  private readonly body = make("div", { class: "answers" });
  private readonly feedback = make("div", { class: "feedback", role: "status" });
  private readonly actions = make("div", { class: "actions" });
  private said: { right: boolean; away?: number } | null = null;
  private pointed = false;
  private opened = false; // the list of places
  private taken = -1; // what was chosen in it

  constructor(
    private readonly question: Question,
    private readonly number: number,
    private result: Result,
    private readonly view: LessonView,
    private readonly pointing: Pointing,
    private readonly words: Words,
    private readonly answered: (right: boolean, response: string) => void,
  ) {
    const id = `question-${number}`;
    const ask = make("h3", { id }, question.ask);
    this.element = make("section", { class: "question", "aria-labelledby": id });
    this.element.append(this.label, ask, this.body, this.feedback, this.actions);
    if (result !== "-") this.said = { right: result !== "0" };
    if ("choices" in question) this.choices(question, id);
    // A place's list is made when the words are known.
  }

  speak(): void {
    const { words, question } = this;
    this.label.textContent = words.say("question", { number: this.number + 1 });
    if ("candidates" in question) this.places(question);
    this.tell();
  }

  private choices(question: ChoiceQuestion, id: string): void {
    const type = question.several ? "checkbox" : "radio";
    const group = make("div", { role: question.several ? "group" : "radiogroup", "aria-labelledby": id, class: "options" });
    question.choices.forEach((choice, k) => {
      const input = make("input", { type, name: id, value: k });
      input.addEventListener("change", () => this.tell());
      group.append(make("label", { class: "option" }, input, make("span", {}, choice)));
    });
    this.body.replaceChildren(group);
  }

  private get chosen(): number[] {
    return [...this.body.querySelectorAll<HTMLInputElement>("input:checked")].map((each) => Number(each.value));
  }

  private check(question: ChoiceQuestion): void {
    const { chosen } = this;
    if (!chosen.length) return;
    const right = chosen.length === question.answers.length && chosen.every((each) => question.answers.includes(each));
    const response = chosen.map((each) => each + 1).join(",");
    this.judge(right, question.several ? `{${response}}` : response);
  }

  private places(question: PlaceQuestion): void {
    const { words } = this;
    const frame = this.frame(question);
    const names = namesOf(question.candidates, frame, this.view.stages[0], words);
    const summary = make("summary", {}, words.say("answer.list"));
    const rows = make("ol", { class: "candidates" });
    question.candidates.forEach((candidate, k) => {
      const button = make("button", { type: "button" });
      const letter = candidate.kind === "corner" ? candidate.name : String(k + 1);
      button.append(make("span", { class: "number" }, letter), make("span", {}, names[k]));
      if (k === this.taken) button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        this.taken = k;
        this.numbered(question);
        this.judge(candidate.right, `${candidate.kind} ${candidate.name}`);
        this.body.querySelectorAll<HTMLElement>(".candidates button")[k].focus();
      });
      rows.append(make("li", {}, button));
    });
    const details = make("details", { open: this.opened }, summary, rows);
    details.addEventListener("toggle", () => {
      if (details.open === this.opened) return;
      this.opened = details.open;
      this.numbered(question);
    });
    this.body.replaceChildren(this.pointButton(question), details);
  }

  private pointButton(question: PlaceQuestion): HTMLElement {
    const button = make("button", { type: "button", class: "point", "aria-pressed": this.pointed });
    button.append(icon("point"), this.words.say(this.pointed ? "answer.waiting" : "answer.picture"));
    button.addEventListener("click", () => (this.pointed ? this.pointing.end() : this.point(question)));
    return button;
  }

  /** Lets the student click on the tissue. */
  private point(question: PlaceQuestion): void {
    this.toStep(question);
    this.pointing.ask(
      question.ask,
      (place) => this.clicked(question, place),
      () => {
        this.pointed = false;
        this.speak();
      },
    );
    this.pointed = true;
    this.taken = -1;
    this.said = this.result === "-" ? null : this.said;
    this.speak();
  }

  private clicked(question: PlaceQuestion, place: THREE.Vector3): void {
    const frame = Math.floor(this.view.player.time + 1e-6);
    const stage = this.view.stages[0];
    const rights = question.candidates.filter((each) => each.right);
    const gaps = rights.map((each) => distance(place, each.places, frame, stage, question.within));
    const away = Math.min(...gaps);
    const right = away <= question.within;
    this.pointing.end();
    this.pointing.clear();
    this.pointing.markClick(place, right);
    this.judge(right, `${Number.isFinite(away) ? away.toFixed(1) : "?"} mm`, away);
  }

  private judge(right: boolean, response: string, away?: number): void {
    this.said = { right, away };
    if (this.result === "-") this.result = right ? "1" : "0";
    else if (this.result === "0" && right) this.result = "2";
    this.answered(right, response);
    if (right) this.show();
    this.speak();
    this.feedback.scrollIntoView({ block: "nearest" });
  }

  /** Shows the right place, or ticks the right choices. */
  private show(): void {
    const { question } = this;
    if ("candidates" in question) {
      this.toStep(question);
      for (const each of question.candidates) if (each.right) this.pointing.mark("answer", "", each.places);
    } else {
      this.body.querySelectorAll<HTMLInputElement>("input").forEach((input, k) => {
        input.checked = question.answers.includes(k);
      });
    }
  }

  private numbered(question: PlaceQuestion): void {
    this.pointing.end();
    this.pointing.clear();
    if (!this.opened) return;
    this.toStep(question);
    if (question.candidates.some((each) => each.kind === "corner")) {
      this.view.shown.letters = true;
      this.view.changed();
    }
    question.candidates.forEach((each, k) => {
      if (each.kind !== "corner") this.pointing.mark("numbered", String(k + 1), each.places);
    });
  }

  private toStep({ step }: Question): void {
    if (step !== null && this.view.player.step !== step) this.view.player.toStep(step);
  }

  private frame(question: PlaceQuestion): number {
    const { steps } = this.view.player.timeline;
    return steps[question.step ?? 0]?.frame ?? 0;
  }

  /** Says what came of the answer and offers what can be done now. */
  private tell(): void {
    const { words, question, said } = this;
    const state = said === null ? "" : said.right ? "right" : "wrong";
    this.element.classList.toggle("is-right", state === "right");
    this.element.classList.toggle("is-wrong", state === "wrong");
    const parts: Node[] = [];
    if (said) {
      const away = !said.right && said.away !== undefined && Number.isFinite(said.away);
      const why = said.right ? question.right : question.wrong;
      const verdict = make("b", {}, words.say(state));
      const far = away ? words.say("away", { distance: Math.round(said.away!) }) : "";
      parts.push(icon(said.right ? "check" : "close"), make("p", {}, verdict, " ", [why, far].filter(Boolean).join(" ")));
    }
    const text = parts.map((each) => each.textContent).join("");
    if (text !== this.feedback.textContent || !text) this.feedback.replaceChildren(...parts);
    this.actions.replaceChildren(...this.offers());
  }

  private offers(): HTMLElement[] {
    const { words, question, said } = this;
    const made: HTMLElement[] = [];
    const add = (key: string, action: () => void, primary = false): HTMLButtonElement => {
      const button = make("button", { type: "button", class: primary ? "primary" : "" }, words.say(key));
      button.addEventListener("click", action);
      made.push(button);
      return button;
    };
    if ("choices" in question && !said?.right) {
      const check = add("check", () => this.check(question), true);
      check.setAttribute("aria-disabled", String(!this.chosen.length));
    }
    if ("choices" in question && question.step !== null && this.view.player.timeline.steps.length) {
      add("show.step", () => this.toStep(question)).textContent = words.say("show.step", { number: question.step + 1 });
    }
    if (said && !said.right) {
      add("show.answer", () => {
        this.pointing.end();
        this.pointing.clear();
        this.show();
      });
    }
    return made;
  }
}
