import { infiniteQueryOptions, queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "./client";
import { after, before, everyPage } from "./batches";
import type {
  AuditEntry,
  Invitation,
  InvitationNew,
  KeyNew,
  NewInvitation,
  NewKey,
  Person,
  RoleUpdate,
  SignedInBrowser,
} from "./types";

const ENTRIES = 50;

/** Browsers of others sign in without a change that would be heard of. */
const LOOK_AGAIN_MS = 15_000;

export const peopleQuery = queryOptions({
  queryKey: ["people", "everybody"],
  queryFn: ({ signal }) =>
    everyPage<Person>((last, limit) =>
      unwrap(api.GET("/api/people", { params: { query: { limit, ...after(last) } }, signal })),
    ),
  refetchInterval: LOOK_AGAIN_MS,
});

export const browsersQuery = queryOptions({
  queryKey: ["people", "browsers"],
  queryFn: ({ signal }) =>
    everyPage<SignedInBrowser>((last, limit) =>
      unwrap(api.GET("/api/browsers", { params: { query: { limit, ...before(last) } }, signal })),
    ),
  refetchInterval: LOOK_AGAIN_MS,
});

export const invitationsQuery = queryOptions({
  queryKey: ["people", "invitations"],
  queryFn: ({ signal }) =>
    everyPage<Invitation>((last, limit) =>
      unwrap(
        api.GET("/api/invitations", { params: { query: { limit, ...before(last) } }, signal }),
      ),
    ),
});

export const keysQuery = queryOptions({
  queryKey: ["people", "keys"],
  queryFn: ({ signal }) => unwrap(api.GET("/api/keys", { signal })),
});

/** The log, page by page, newest first. */
export const auditQuery = infiniteQueryOptions({
  queryKey: ["people", "audit"],
  queryFn: ({ signal, pageParam }): Promise<AuditEntry[]> =>
    unwrap(
      api.GET("/api/audit", {
        params: {
          query: pageParam === null ? { limit: ENTRIES } : { limit: ENTRIES, before: pageParam },
        },
        signal,
      }),
    ),
  initialPageParam: null as number | null,
  getNextPageParam: (page) => (page.length < ENTRIES ? null : (page.at(-1)?.id ?? null)),
});

export function signOut(): Promise<unknown> {
  return unwrap(api.POST("/api/sign-out"));
}

export function signBrowserOut(id: number): Promise<unknown> {
  return unwrap(api.DELETE("/api/browsers/{browser_id}", { params: { path: { browser_id: id } } }));
}

export function changeRole({ id, ...body }: RoleUpdate & { id: number }): Promise<unknown> {
  return unwrap(
    api.PUT("/api/people/{player_id}/role", { params: { path: { player_id: id } }, body }),
  );
}

export function createInvitation(body: InvitationNew): Promise<NewInvitation> {
  return unwrap(api.POST("/api/invitations", { body }));
}

export function revokeInvitation(id: number): Promise<unknown> {
  return unwrap(
    api.DELETE("/api/invitations/{invitation_id}", { params: { path: { invitation_id: id } } }),
  );
}

export function createKey(body: KeyNew): Promise<NewKey> {
  return unwrap(api.POST("/api/keys", { body }));
}

export function revokeKey(id: number): Promise<unknown> {
  return unwrap(api.DELETE("/api/keys/{key_id}", { params: { path: { key_id: id } } }));
}
