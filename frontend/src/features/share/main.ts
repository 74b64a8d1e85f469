/** The script of share pages, which trainer/sharing puts into each. */
import "./share.css";

import { Films } from "./data";
import { playInStep } from "./player";
import { playTile } from "./tiles";

const films = new Films(document);
const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
const player = document.querySelector<HTMLElement>("#player");
if (player) playInStep(player, films, calm);
for (const tile of document.querySelectorAll<HTMLElement>(".tile")) playTile(tile, films, calm);
