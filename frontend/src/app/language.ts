/** The language of the page: the person's choice, else the browser's, else English. */
import type { Messages } from "@lingui/core";

import { i18n } from "@/lib/i18n";
import { ofBrowser } from "@/lib/browser/storage";

/** Every language there is, by its own name. */
export const LANGUAGES = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof LANGUAGES;

const KEY = "tril.language";

/** The catalogues, each in a chunk of its own. English has none: it stands in the source. */
const CATALOGUES: Partial<Record<Language, () => Promise<{ messages: Messages }>>> = {
  de: () => import("@/texts/de.po"),
};

/** Returns the language in use. */
export function readLanguage(): Language {
  return isLanguage(i18n.locale) ? i18n.locale : "en";
}

/** Returns what was chosen in this browser, else the first of its languages that there is. */
export function preferredLanguage(): Language {
  const wanted = [ofBrowser.read(KEY) ?? "", ...navigator.languages].map(
    (tag) => tag.split("-")[0] ?? "",
  );
  return wanted.find(isLanguage) ?? "en";
}

/** Shows the page in the preferred language; in English if the catalogue can't be loaded. */
export async function startLanguage(): Promise<void> {
  replaceNoLanguage();
  try {
    await activate(preferredLanguage());
  } catch {
    // The server can't be reached, which the page says itself.
  }
}

/** Shows the page in a language and stores the choice. */
export async function setLanguage(language: Language): Promise<void> {
  await activate(language);
  ofBrowser.write(KEY, language);
}

/** Calls back when the language changes; returns what ends that. */
export function onLanguage(listener: () => void): () => void {
  return i18n.on("change", listener);
}

/**
 * Lets scripts find a language where the machine's locale is "C", which WebKitGTK passes on though
 * it is none: uPlot would fail to load.
 */
function replaceNoLanguage(): void {
  try {
    Intl.getCanonicalLocales(navigator.language);
  } catch {
    Object.defineProperty(navigator, "language", { value: "en", configurable: true });
  }
}

async function activate(language: Language): Promise<void> {
  const catalogue = await CATALOGUES[language]?.();
  if (catalogue) i18n.load(language, catalogue.messages);
  i18n.activate(language);
  document.documentElement.lang = language;
}

function isLanguage(tag: string): tag is Language {
  return tag in LANGUAGES;
}
