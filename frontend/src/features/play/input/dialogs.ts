/** Whether a modal dialog takes what is pressed now. */
export function dialogIsOpen(): boolean {
  return document.querySelector("dialog[open]") !== null;
}
