import "@testing-library/jest-dom/vitest";

import { cleanup, configure } from "@testing-library/react";
import { afterEach, vi } from "vitest";

import { forgetDrafts } from "@/lib/browser/drafts";

// Pages load in parts, which takes jsdom longer than the usual second where the machine has other
// work. A test waits this long only when it fails.
configure({ asyncUtilTimeout: 10_000 });

// Stubs for what jsdom lacks.

HTMLDialogElement.prototype.showModal = function showModal(this: HTMLDialogElement) {
  this.open = true;
};
HTMLDialogElement.prototype.close = function close(this: HTMLDialogElement) {
  this.open = false;
};

globalThis.ResizeObserver = class {
  observe() {
    /* nothing is ever resized here */
  }
  unobserve() {
    /* nothing is ever resized here */
  }
  disconnect() {
    /* nothing is ever resized here */
  }
};

globalThis.matchMedia = (query: string) => {
  const list = new EventTarget() as EventTarget & { matches: boolean; media: string };
  list.matches = false;
  list.media = query;
  return list as unknown as MediaQueryList;
};

HTMLElement.prototype.scrollIntoView = function scrollIntoView() {
  /* nothing is laid out here */
};

window.scrollTo = () => {
  /* nothing is laid out here */
};

/** A context that ignores what is drawn. */
HTMLCanvasElement.prototype.getContext = function getContext() {
  return {
    createImageData: (width: number, height: number) => ({
      width,
      height,
      data: new Uint8ClampedArray(width * height * 4),
    }),
    putImageData: vi.fn(),
  };
} as unknown as HTMLCanvasElement["getContext"];

afterEach(() => {
  forgetDrafts();
  cleanup();
  vi.unstubAllGlobals();
  sessionStorage.clear();
  localStorage.clear();
});
