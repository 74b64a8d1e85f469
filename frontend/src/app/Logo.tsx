import { pixelPath, SIGN } from "@/lib/pixels";

/** The sign of Tril. */
export function Logo({ scale = 2 }: { scale?: number }) {
  const side = SIGN.length;
  return (
    <svg
      viewBox={`0 0 ${side} ${side}`}
      width={side * scale}
      height={side * scale}
      fill="var(--accent)"
      shapeRendering="crispEdges"
      aria-hidden="true"
    >
      <path d={pixelPath(SIGN, 0, 0)} />
    </svg>
  );
}
