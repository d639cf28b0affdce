import { Text } from "@mantine/core";
import type { UseQueryResult } from "@tanstack/react-query";
import { SearchX } from "lucide-react";
import type { ReactNode } from "react";
import { ApiError } from "@/api/problem";
import { capital } from "@/format/format";
import { Empty, Failure, Waiting } from "./Notice";
import { Page } from "./Page";

interface OneProps<T> {
  query: Pick<UseQueryResult<T>, "data" | "error" | "isPending" | "refetch">;
  /** What it is: a job, a shape. */
  what: string;
  /** Why there may be none. */
  missing: string;
  /** The way back to all of them. */
  back: ReactNode;
  children: (found: T) => ReactNode;
}

/** The page of one thing: waits for it, shows it, or tells that it is not there. */
export function One<T>({ query, what, missing, back, children }: OneProps<T>) {
  const { data, error, isPending, refetch } = query;
  if (data !== undefined) return children(data);
  const gone = error instanceof ApiError && (error.status === 404 || error.status === 422);
  return (
    <Page title="" tab={capital(what)}>
      {isPending ? (
        <Waiting label={`Loading the ${what}…`} />
      ) : gone ? (
        <Empty icon={<SearchX size={32} />} title={`There is no such ${what}`}>
          <Text size="sm" c="dimmed">
            {missing}
          </Text>
          {back}
        </Empty>
      ) : (
        <Failure error={error} onRetry={() => void refetch()} />
      )}
    </Page>
  );
}
