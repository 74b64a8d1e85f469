import { QueryClientProvider } from "@tanstack/react-query";
import { render } from "@testing-library/react";
import type { ReactNode } from "react";
import { createMemoryRouter, RouterProvider } from "react-router";

import type { TaughtGame } from "@/api/types";
import { createQueryClient } from "@/app/query-client";
import { ToastProvider } from "@/components/feedback/Toasts";
import { GameProvider } from "@/games/game";

import { SPACE_INVADERS } from "./games";

const NO_SETTINGS = { options: {} };

/** Renders an element as the application would, at an address, on a page of a game. */
export function show(element: ReactNode, path = "/", game: TaughtGame = SPACE_INVADERS) {
  const client = createQueryClient();
  client.setDefaultOptions({ queries: { retry: false } });
  const router = createMemoryRouter(
    [
      {
        path: "/",
        element: (
          <GameProvider game={game} settings={NO_SETTINGS}>
            {element}
          </GameProvider>
        ),
      },
      { path: "*", element: <p>Another page</p> },
    ],
    { initialEntries: [path] },
  );
  render(
    <QueryClientProvider client={client}>
      <ToastProvider>
        <RouterProvider router={router} />
      </ToastProvider>
    </QueryClientProvider>,
  );
  return { client, router };
}
