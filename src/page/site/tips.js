// Explanations: what has a text `data-tip` shows it under the mouse, with the keyboard's focus, and when it is touched.

const box = document.getElementById("tip");
let shown = null;

// The element explains itself by `text`, also to who cannot point at it.
export function explain(element, text) {
  if (element.dataset.tip === text && element.hasAttribute("aria-description")) return;
  element.dataset.tip = text;
  element.setAttribute("aria-description", text);
  if (!element.matches("button, input, select, label")) element.tabIndex = 0;
  if (element === shown) show(element);
}

function show(element) {
  shown = element;
  box.hidden = !element;
  if (!element) return;
  box.textContent = element.dataset.tip;
  const at = element.getBoundingClientRect();
  const { offsetWidth: width, offsetHeight: height } = box;
  const below = at.bottom + 6;
  const top = below + height <= innerHeight ? below : Math.max(4, at.top - height - 6);
  box.style.left = `${Math.max(4, Math.min(at.left, innerWidth - width - 4))}px`;
  box.style.top = `${top}px`;
}

const about = (event) => event.target.closest?.("[data-tip]") ?? null;
let pressed = null;  // the button pressed last, until the mouse is elsewhere
document.addEventListener("pointerover", (event) => {
  const over = about(event);
  if (over !== pressed) pressed = null;
  if (!pressed) show(over);
});
document.documentElement.addEventListener("pointerleave", () => show(null));
document.addEventListener("focusin", (event) => { if (event.target !== pressed && event.target.matches(":focus-visible, [tabindex]")) show(about(event)); });
document.addEventListener("focusout", () => show(null));
// Who presses a button has read about it; under a finger the text has just appeared.
document.addEventListener("click", (event) => {
  if (event.pointerType === "touch" || !event.target.closest?.("button")) return;
  pressed = about(event);
  show(null);
});

for (const element of document.querySelectorAll("[data-tip]")) explain(element, element.dataset.tip);
