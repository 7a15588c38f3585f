// Opens the lesson that stands in the same file, or says why it cannot.
import { Arrays, BrokenLesson, inflate } from "./arrays";
import { checkWhole, CourseView } from "./course_view";
import type { Course, Lesson } from "./lesson";
import { LessonView } from "./lesson_view";
import { reporterOf } from "./reporter";
import courseStyle from "./course.css";
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
  // Without them, or with half of the second, the file is cut: the sentence that stands there says so.
  if (!notice || !data) return;
  let lesson: Lesson | Course;
  try {
    lesson = JSON.parse(data.textContent ?? "") as Lesson | Course;
  } catch {
    return;
  }
  const words = new Words(lesson, lesson.language);
  try {
    if (!document.createElement("canvas").getContext("webgl2")) throw new BrokenLesson("broken.graphics");
    await ("chapters" in lesson ? openCourse(lesson, words, notice) : openLesson(lesson, words, notice));
  } catch (error) {
    if (!notice.isConnected) document.body.replaceChildren(notice);
    tell(error instanceof BrokenLesson ? words.say(error.key, error.values) : words.say("broken.data"));
    if (!(error instanceof BrokenLesson)) console.error(error);
  }
}

async function openLesson(lesson: Lesson, words: Words, notice: HTMLElement): Promise<void> {
  const arrays = document.getElementById("arrays");
  const block = await inflate(arrays?.textContent ?? "", lesson.bytes, lesson.size);
  arrays?.remove();
  dress();
  const view = new LessonView(lesson, words, new Arrays(block));
  notice.remove();
  document.body.prepend(view.element);
  view.start();
  Object.assign(window, { lappetLesson: view.scripting() });
}

async function openCourse(course: Course, words: Words, notice: HTMLElement): Promise<void> {
  const texts = course.parts.map(({ bytes }, k) => {
    const arrays = document.getElementById(`arrays-${k}`);
    const text = arrays?.textContent ?? "";
    checkWhole(text, bytes);
    arrays?.remove();
    return text;
  });
  dress();
  notice.remove();
  await new CourseView(course, words, texts, reporterOf(course)).start();
}

function dress(): void {
  document.head.append(Object.assign(document.createElement("style"), { textContent: style + courseStyle }));
}

if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", () => void open());
else void open();
