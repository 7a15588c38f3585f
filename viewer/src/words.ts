// What the lesson says, in the language that is chosen.
import type { Lesson } from "./lesson";

export class Words {
  constructor(
    private readonly lesson: Pick<Lesson, "words">,
    public language: string,
  ) {}

  get languages(): string[] {
    return Object.keys(this.lesson.words);
  }

  say(key: string, values: Record<string, string | number> = {}): string {
    const text = this.lesson.words[this.language]?.[key] ?? this.lesson.words.en?.[key] ?? key;
    return text.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
  }
}

/** Each language's own name. */
export const LANGUAGE_NAMES: Record<string, string> = {
  en: "English",
  de: "Deutsch",
  fr: "Français",
  es: "Español",
  zh: "中文",
};
