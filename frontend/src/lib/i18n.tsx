/** What the macros `t`, `plural` and `Trans` call: the catalogue of the language in use. */
import { setupI18n } from "@lingui/core";
import { TransNoContext, type TransProps } from "@lingui/react/server";

/** English from the start: its messages stand in the source and need no catalogue. */
export const i18n = setupI18n({ locale: "en", messages: { en: {} } });

// Messages are compiled when the page is built; what is left as a string has no parameters.
i18n.setMessagesCompiler((message) => [message]);

/** A message with elements in it. It needs no provider: a change of language renders the page anew. */
export function Trans(props: TransProps) {
  return <TransNoContext {...props} lingui={{ i18n }} />;
}
