// The panel of options: skin, view, what is shown, language, background. Plain form controls throughout.
import { VIEWS, type View } from "./camera";
import { iconButton, make, name } from "./elements";
import { cssColor } from "./materials";
import type { Lesson } from "./lesson";
import type { Shown } from "./stage";
import { LANGUAGE_NAMES, type Words } from "./words";

export type Theme = "auto" | "light" | "dark";
type Toggle = "hooks" | "threads" | "marks" | "letters" | "landmarks" | "around" | "vessels";

export interface OptionsActions {
  changed(): void;
  view(view: View): void;
  language(language: string): void;
  theme(theme: Theme): void;
  print(): void;
  close(): void;
}

export class Options {
  readonly element = make("aside", { id: "options" });
  private readonly told: (() => void)[] = [];

  constructor(
    lesson: Lesson,
    private readonly words: Words,
    private readonly shown: Shown,
    available: Toggle[],
    private readonly actions: OptionsActions,
  ) {
    const close = iconButton("close", () => actions.close(), { id: "close-options" });
    const heading = make("h2");
    this.say(() => {
      heading.textContent = words.say("options");
      name(close, words.say("close"));
      name(this.element, words.say("options"));
    });
    this.element.append(make("div", { class: "panel-head" }, heading, close));
    this.element.append(this.looks(lesson), this.views(), this.toggles(available));
    const layers = this.layers(lesson);
    if (layers) this.element.append(layers);
    this.element.append(this.language(), this.theme(), this.keys(), this.foot(lesson));
  }

  /** Says everything again, in the language that is chosen now. */
  speak(): void {
    for (const each of this.told) each();
  }

  showView(view: View | null): void {
    for (const button of this.element.querySelectorAll<HTMLButtonElement>("[data-view]")) {
      button.setAttribute("aria-pressed", String(button.dataset.view === view));
    }
  }

  /** Sets the boxes to what is shown, where that was changed elsewhere. */
  showShown(): void {
    for (const box of this.element.querySelectorAll<HTMLInputElement>("input[type=checkbox]")) {
      box.checked = this.shown[box.name as Toggle];
    }
  }

  private say(how: () => void): void {
    this.told.push(how);
    how();
  }

  private group(key: string): HTMLFieldSetElement {
    const legend = make("legend");
    this.say(() => (legend.textContent = this.words.say(key)));
    return make("fieldset", {}, legend);
  }

  private looks(lesson: Lesson): HTMLElement {
    const group = this.group("surface");
    const row = make("div", { class: "choices" });
    const maps = Object.keys(lesson.procedures[0].quantities).filter((each) =>
      lesson.procedures.every((procedure) => each in procedure.quantities),
    );
    const known = ["painted", "grid", ...["tension", "strain", "stress"].filter((each) => maps.includes(each))];
    for (const look of known) {
      const input = make("input", { type: "radio", name: "look", value: look, checked: look === this.shown.look });
      input.addEventListener("change", () => {
        this.shown.look = look as Shown["look"];
        this.actions.changed();
      });
      const text = make("span");
      this.say(() => (text.textContent = this.words.say(`surface.${look}`)));
      row.append(make("label", { class: "choice" }, input, text));
    }
    group.append(row);
    return group;
  }

  private views(): HTMLElement {
    const group = this.group("view");
    const row = make("div", { class: "choices" });
    for (const view of VIEWS) {
      const button = make("button", { type: "button", "data-view": view, "aria-pressed": "false" });
      button.addEventListener("click", () => this.actions.view(view));
      this.say(() => (button.textContent = this.words.say(`view.${view}`)));
      row.append(button);
    }
    group.append(row);
    return group;
  }

  private toggles(available: Toggle[]): HTMLElement {
    const group = this.group("show");
    for (const each of available) {
      const input = make("input", { type: "checkbox", name: each, checked: this.shown[each] });
      input.addEventListener("change", () => {
        this.shown[each] = input.checked;
        this.actions.changed();
      });
      const text = make("span");
      this.say(() => (text.textContent = this.words.say(`show.${each}`)));
      group.append(make("label", { class: "check" }, input, text));
    }
    return group;
  }

  private layers(lesson: Lesson): HTMLElement | null {
    const colors = new Map(lesson.procedures.flatMap((procedure) => Object.entries(procedure.layers.colors)));
    const kinds = [...new Set(lesson.procedures.flatMap((procedure) => procedure.layers.kind))];
    if (kinds.length < 2) return null;
    const heading = make("h3");
    this.say(() => (heading.textContent = this.words.say("layers")));
    const list = make("ul", { class: "layers" });
    for (const kind of kinds) {
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = cssColor(colors.get(kind)!);
      const text = make("span");
      this.say(() => (text.textContent = this.words.say(`layer.${kind}`)));
      list.append(make("li", {}, swatch, text));
    }
    return make("div", { class: "group" }, heading, list);
  }

  private language(): HTMLElement {
    const select = make("select", { id: "language", name: "language" });
    for (const each of this.words.languages) {
      const option = make("option", { value: each, lang: each }, LANGUAGE_NAMES[each] ?? each);
      option.selected = each === this.words.language;
      select.append(option);
    }
    select.addEventListener("change", () => this.actions.language(select.value));
    return this.labeled("language", select);
  }

  private theme(): HTMLElement {
    const select = make("select", { id: "theme", name: "theme" });
    for (const each of ["auto", "light", "dark"]) {
      const option = make("option", { value: each, selected: each === (document.documentElement.dataset.theme ?? "auto") });
      this.say(() => (option.textContent = this.words.say(`theme.${each}`)));
      select.append(option);
    }
    select.addEventListener("change", () => this.actions.theme(select.value as Theme));
    return this.labeled("theme", select);
  }

  private labeled(key: string, select: HTMLSelectElement): HTMLElement {
    const text = make("span");
    this.say(() => (text.textContent = this.words.say(key)));
    return make("label", { class: "labeled" }, text, select);
  }

  private keys(): HTMLElement {
    const summary = make("summary");
    const list = make("dl", { class: "keys" });
    this.say(() => {
      summary.textContent = this.words.say("keys");
      list.replaceChildren();
      for (const each of ["space", "frames", "steps", "turn", "zoom", "views"]) {
        const [key, what] = this.words.say(`keys.${each}`).split("|");
        list.append(make("dt", {}, key), make("dd", {}, what));
      }
    });
    return make("details", {}, summary, list);
  }

  private foot(lesson: Lesson): HTMLElement {
    const print = make("button", { type: "button", id: "print" });
    print.addEventListener("click", () => this.actions.print());
    const made = make("p", { class: "made" });
    this.say(() => {
      print.textContent = this.words.say("print");
      made.textContent = this.words.say("made", { version: lesson.version });
    });
    return make("div", { class: "foot" }, print, made);
  }
}
