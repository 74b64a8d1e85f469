import "@/styles/tokens.css";
import "@/styles/base.css";

import { QueryClientProvider } from "@tanstack/react-query";
import { startTransition, StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { RouterProvider } from "react-router/dom";

import { Localised } from "@/app/Localised";
import { loadFirstPage } from "@/app/first-page";
import { createQueryClient } from "@/app/query-client";
import { createRouter } from "@/app/router";
import { ToastProvider } from "@/components/feedback/Toasts";
import { startLanguage } from "@/app/language";

const root = document.getElementById("root");
if (!root) throw new Error("The page has no element with the id root.");

const page = createRoot(root);
const client = createQueryClient();
const router = createRouter();

// The first text that is shown is in the right language, and the first page has what it shows. As a
// transition it is rendered in slices, between which the browser answers to input.
void Promise.all([startLanguage(), loadFirstPage(client, location.pathname)]).then(() =>
  startTransition(() =>
    page.render(
      <StrictMode>
        <Localised>
          <QueryClientProvider client={client}>
            <ToastProvider>
              <RouterProvider router={router} />
            </ToastProvider>
          </QueryClientProvider>
        </Localised>
      </StrictMode>,
    ),
  ),
);
