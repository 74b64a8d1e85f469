import { fireEvent, screen } from "@testing-library/react";
import { beforeEach, describe, expect, it } from "vitest";

import { Tour } from "@/features/behaviours/tour/Tour";

import { show } from "../../support/page";

beforeEach(() => localStorage.clear());

function press(name: string) {
  fireEvent.click(screen.getByText(name, { selector: "button" }));
}

describe("the tour", () => {
  it("goes through five steps and is not shown again", () => {
    show(<Tour isNew />);
    const titles: (string | null)[] = [];
    for (let step = 1; step <= 5; step += 1) {
      expect(screen.getByText(`Step ${step} of 5`)).toBeVisible();
      titles.push(screen.getByRole("heading").textContent);
      press(step < 5 ? "Next" : "Finish the tour");
    }
    expect(titles).toEqual(["Play", "Keep", "Rank", "Train", "Look"]);
    expect(screen.queryByRole("region", { name: "Tour" })).toBeNull();
    show(<Tour isNew />);
    expect(screen.queryByRole("region", { name: "Tour" })).toBeNull();
  });

  it("can be skipped, and the address brings it back", () => {
    show(<Tour isNew />);
    press("Skip the tour");
    expect(screen.queryByRole("region", { name: "Tour" })).toBeNull();
    const { router } = show(<Tour isNew={false} />, "/?tour");
    press("Next");
    press("Back");
    press("Skip the tour");
    expect(router.state.location.search).toBe("");
    expect(screen.queryByRole("region", { name: "Tour" })).toBeNull();
  });

  it("is not for people who have played already", () => {
    show(<Tour isNew={false} />);
    expect(screen.queryByRole("region", { name: "Tour" })).toBeNull();
  });
});
