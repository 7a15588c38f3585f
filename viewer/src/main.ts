// Opens the lesson that stands in the same file, or says why it cannot.
import { Arrays, BrokenLesson, inflate } from "./arrays";
import type { Lesson } from "./lesson";
import { LessonView } from "./lesson_view";
import style from "./style.css";
import { Words } from "./words";

function tell(text: string): void {
  const notice = document.querySelector<HTMLElement>("#notice p");
  if (notice) {
    notice.setAttribute("role", "alert");
    notice.textContent = text;
  }
}

async function open(): Promise<void> {
  const notice = document.getElementById("notice");
  const data = document.getElementById("lesson");
  const arrays = document.getElementById("arrays");
  // Without them, or with half of the first, the file is cut: the sentence that stands there says so.
  if (!notice || !data || !arrays) return;
  let lesson: Lesson;
  try {
    lesson = JSON.parse(data.textContent ?? "");
  } catch {
    return;
  }
  const words = new Words(lesson, lesson.language);
  try {
    const block = await inflate(arrays.textContent ?? "", lesson.bytes, lesson.size);
    if (!document.createElement("canvas").getContext("webgl2")) throw new BrokenLesson("broken.graphics");
    arrays.remove();
    document.head.append(Object.assign(document.createElement("style"), { textContent: style }));
    const view = new LessonView(lesson, words, new Arrays(block));
    notice.remove();
    document.body.prepend(view.element);
    view.start();
    Object.assign(window, { lappetLesson: view.scripting() });
  } catch (error) {
    tell(error instanceof BrokenLesson ? words.say(error.key, error.values) : words.say("broken.data"));
    if (!(error instanceof BrokenLesson)) console.error(error);
  }
}

if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", () => void open());
else void open();
