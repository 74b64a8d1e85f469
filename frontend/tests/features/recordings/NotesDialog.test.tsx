import { screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import { describe, expect, it, vi } from "vitest";

import { NotesDialog } from "@/features/recordings/NotesDialog";

import { recording } from "../../support/data";
import { show } from "../../support/page";

const onSave = vi.fn(() => Promise.resolve());

function Opener() {
  const [open, setOpen] = useState(false);
  return (
    <>
      <button onClick={() => setOpen(true)}>Open</button>
      {open && (
        <NotesDialog recording={recording()} onSave={onSave} onClose={() => setOpen(false)} />
      )}
    </>
  );
}

async function open(): Promise<HTMLElement> {
  await userEvent.click(screen.getByRole("button", { name: "Open" }));
  return screen.getByLabelText("Note");
}

function closeByAccident() {
  // A click on the backdrop.
  return userEvent.click(screen.getByRole("dialog"));
}

describe("a dialog with a form", () => {
  it("focuses its first field and gives the focus back", async () => {
    show(<Opener />);
    expect(await open()).toHaveFocus();
    await userEvent.click(screen.getByRole("button", { name: "Close" }));
    expect(screen.getByRole("button", { name: "Open" })).toHaveFocus();
  });

  it("keeps what was typed when it is closed by accident, until it is cancelled or saved", async () => {
    show(<Opener />);
    await userEvent.type(await open(), "steady");
    await closeByAccident();
    expect(screen.queryByRole("dialog")).toBeNull();
    expect(await open()).toHaveValue("steady");
    await userEvent.click(screen.getByRole("button", { name: "Cancel" }));
    expect(await open()).toHaveValue("");
    await userEvent.type(screen.getByLabelText("Note"), "calm");
    await userEvent.click(screen.getByRole("button", { name: "Save note" }));
    expect(onSave).toHaveBeenCalledWith("calm");
    expect(await open()).toHaveValue("");
  });

  it("keeps what could not be saved", async () => {
    onSave.mockImplementationOnce(() => Promise.reject(new Error("Busy.")));
    show(<Opener />);
    await userEvent.type(await open(), "steady");
    await userEvent.click(screen.getByRole("button", { name: "Save note" }));
    expect(screen.queryByRole("dialog")).toBeNull();
    expect(await open()).toHaveValue("steady");
  });
});
