import { type Drawn, NiftiStream } from "./niftiStream";

export type Ask = { begin: { most: number; labels: boolean } } | { piece: Uint8Array<ArrayBuffer> } | { end: true };
export type Told =
  /** A piece was taken in, and whether more are needed. */
  { is: "taken"; more: boolean } | { is: "drawn"; drawn: Drawn } | { is: "problem"; problem: string };

/** Where pieces of the file go, as they are or to be uncompressed. */
interface Sink {
  write(piece: Uint8Array<ArrayBuffer>): Promise<void>;
  close(): Promise<void>;
}

let stream: NiftiStream | null = null;
let more = true;
let sink: Sink | null = null;
/** Pieces are taken in one after the other. */
let before: Promise<void> = Promise.resolve();

function take(piece: Uint8Array): void {
  if (more && stream) more = stream.push(piece);
}

function sinkFor(start: Uint8Array): Sink {
  if (start[0] !== 0x1f || start[1] !== 0x8b) {
    return {
      write: (piece) => {
        take(piece);
        return Promise.resolve();
      },
      close: () => Promise.resolve(),
    };
  }
  const gzip = new DecompressionStream("gzip");
  const writer = gzip.writable.getWriter();
  const reader = gzip.readable.getReader();
  const all = (async () => {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      take(value);
    }
  })();
  all.catch(() => undefined); // told where it is waited for
  return {
    write: (piece) => Promise.race([writer.write(piece), all]),
    close: async () => {
      // Of a file of which the rest is not needed, the end is not there.
      if (!more) return;
      await writer.close();
      await all;
    },
  };
}

async function handle(ask: Ask): Promise<void> {
  const tell = (told: Told, given: Transferable[] = []) => self.postMessage(told, { transfer: given });
  if ("begin" in ask) {
    stream = new NiftiStream(ask.begin.most, ask.begin.labels);
  } else if ("piece" in ask) {
    sink ??= sinkFor(ask.piece);
    await sink.write(ask.piece);
    tell({ is: "taken", more });
  } else if (stream) {
    await sink?.close();
    const drawn = stream.finish();
    tell({ is: "drawn", drawn }, [drawn.content]);
  }
}

self.onmessage = ({ data }: MessageEvent<Ask>) => {
  before = before.then(() => handle(data));
  before.catch((error: unknown) => {
    const told: Told = { is: "problem", problem: error instanceof Error ? error.message : String(error) };
    self.postMessage(told);
  });
};
