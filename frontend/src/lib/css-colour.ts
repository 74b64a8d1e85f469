/** Colours of the page's tokens for drawings that know no CSS variables. */

/**
 * The colour that a CSS expression such as `var(--ink)` stands for now.
 *
 * @param inside The element whose theme counts: the game's screen is dark in either.
 */
export function resolveColour(expression: string, inside: Element = document.body): string {
  const probe = document.createElement("span");
  probe.style.color = expression;
  inside.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

/** Calls back when the theme changes, by the system or by the button. */
export function onThemeChange(callback: () => void): () => void {
  const query = matchMedia("(prefers-color-scheme: dark)");
  query.addEventListener("change", callback);
  const observer = new MutationObserver(callback);
  observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  return () => {
    query.removeEventListener("change", callback);
    observer.disconnect();
  };
}
