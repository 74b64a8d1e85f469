/** What the macros `t`, `plural` and `Trans` call: the catalogue of the language in use. */
import { setupI18n } from "@lingui/core";
import { compileMessage } from "@lingui/message-utils/compileMessage";
import { TransNoContext, type TransProps } from "@lingui/react/server";

/** English from the start: its messages stand in the source and need no catalogue. */
export const i18n = setupI18n({ locale: "en", messages: { en: {} } });

type Compiled = ReturnType<typeof compileMessage>;
const compiled = new Map<string, Compiled>();

// A catalogue is compiled when the page is built, the messages in the source when they are first shown.
i18n.setMessagesCompiler((message) => {
  let tokens = compiled.get(message);
  if (!tokens) compiled.set(message, (tokens = compileMessage(message)));
  return tokens;
});

/** A message with elements in it. It needs no provider: a change of language renders the page anew. */
export function Trans(props: TransProps) {
  return <TransNoContext {...props} lingui={{ i18n }} />;
}
