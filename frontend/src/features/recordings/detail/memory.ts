/** The console's RAM at every frame of a recording. */

export const RAM_SIZE = 128;

interface MemoryByte {
  readonly address: number;
  readonly value: number;
  /** Whether it differs from the previous frame's. */
  readonly changed: boolean;
}

/** Returns the RAM at a frame, clamped to the recording. */
export function memoryAt(memory: Uint8Array, frame: number): readonly MemoryByte[] {
  const last = Math.floor(memory.length / RAM_SIZE) - 1;
  const at = Math.min(Math.max(frame, 0), last) * RAM_SIZE;
  return Array.from({ length: RAM_SIZE }, (_, address) => {
    const value = memory[at + address] ?? 0;
    return {
      address,
      value,
      changed: at > 0 && memory[at - RAM_SIZE + address] !== value,
    };
  });
}

/** Formats a byte in hexadecimal: "0a". */
export function hex(value: number): string {
  return value.toString(16).padStart(2, "0");
}
