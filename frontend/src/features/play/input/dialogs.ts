/** Whether a modal dialog is open, which takes the keyboard. */
export function dialogIsOpen(): boolean {
  return document.querySelector("dialog[open]") !== null;
}
