/** The console's RAM at every frame of a recording. */

export const RAM_SIZE = 128;

export interface MemoryByte {
  readonly address: number;
  readonly value: number;
  /** Whether it is another one than a frame before. */
  readonly changed: boolean;
}

/** What is in the RAM at a frame; frames outside the recording are the nearest in it. */
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

/** "0a": a byte as the RAM's table shows it. */
export function hex(value: number): string {
  return value.toString(16).padStart(2, "0");
}
