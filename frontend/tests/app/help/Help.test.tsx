import { screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { expect, it } from "vitest";

import { Help } from "@/app/help/Help";

import { show } from "../../support/page";

it("? shows the keys and leads to the tour, but is a letter in a field", async () => {
  const { router } = show(
    <>
      <Help />
      <input aria-label="Name" />
    </>,
  );
  await userEvent.type(screen.getByLabelText("Name"), "why?");
  expect(screen.queryByRole("dialog")).toBeNull();
  (document.activeElement as HTMLElement).blur();
  await userEvent.keyboard("?");
  const dialog = within(screen.getByRole("dialog", { name: "Keys on this page" }));
  expect(dialog.getByText("close a dialog")).toBeVisible();
  await userEvent.click(dialog.getByRole("link", { name: "Take the tour of Tril" }));
  expect(screen.queryByRole("dialog")).toBeNull();
  expect(router.state.location.search).toBe("?tour");
});
