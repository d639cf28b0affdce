import { useReindexCollection } from "@/api/shapes";
import type { Collection } from "@/api/types";
import { sayFailure } from "@/app/say";
import { adding } from "./adder";

/** Index outdated shapes again, a batch for each of some collections; how far they are is told above the wall. */
export function useReindex(): { reindex: (collections: readonly Collection[]) => void; isPending: boolean } {
  const { mutateAsync, isPending } = useReindexCollection();
  const run = async (collections: readonly Collection[]) => {
    for (const { id, name } of collections) adding.follow(await mutateAsync(id), name);
  };
  return {
    reindex: (collections) =>
      void run(collections.filter(({ outdated }) => outdated > 0)).catch((error: unknown) =>
        sayFailure("Not all are indexed again", error),
      ),
    isPending,
  };
}
