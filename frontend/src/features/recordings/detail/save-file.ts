/** Hands a file that was made or fetched here to the browser's downloads. */
export function saveFile(content: Blob, name: string): void {
  const url = URL.createObjectURL(content);
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  // The browser has taken it up by then; until it is given back it is kept in memory.
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
