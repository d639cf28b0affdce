import "@fontsource-variable/hanken-grotesk/wght.css";
import "@mantine/core/styles.css";
import "@mantine/notifications/styles.css";
import "@/app/app.css";
import { MantineProvider } from "@mantine/core";
import { Notifications } from "@mantine/notifications";
import { QueryClient, QueryClientProvider } from "@tanstack/react-query";
import { RouterProvider } from "@tanstack/react-router";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { connection } from "@/api/connection";
import { ApiError, Unreachable } from "@/api/problem";
import { infoQuery, keys } from "@/api/queries";
import { router } from "@/app/router";
import { theme } from "@/app/theme";
import { additionKeep } from "@/features/shapes/additionKeep";
import { uploads } from "@/features/uploads/uploads";

const client = new QueryClient({
  defaultOptions: {
    queries: {
      // The server may well be on this machine: whether there is an internet says nothing about it.
      networkMode: "always",
      staleTime: 2_000,
      retry: (failures, error) =>
        failures < 2 && (error instanceof Unreachable || (error instanceof ApiError && error.status >= 500)),
      retryDelay: 700,
    },
    mutations: { networkMode: "always" },
  },
});

// While the server is silent one small question is asked again and again; its first answer refreshes everything.
setInterval(() => {
  if (connection.get() === "down") void client.query({ ...infoQuery, staleTime: 0, retry: false }).catch(() => null);
}, 3_000);
connection.subscribe(() => {
  if (connection.get() === "up") void client.invalidateQueries();
});

uploads.onDone = () => void client.invalidateQueries({ queryKey: keys.assetLists });
void uploads.restore();
// Shapes that were being added when the page was left are added further, whatever page comes first.
if (additionKeep.all().length > 0) void import("@/features/shapes/adder");

createRoot(document.getElementById("root") as HTMLElement).render(
  <StrictMode>
    <MantineProvider theme={theme} defaultColorScheme="auto">
      <Notifications position="bottom-right" limit={3} />
      <QueryClientProvider client={client}>
        <RouterProvider router={router} />
      </QueryClientProvider>
    </MantineProvider>
  </StrictMode>,
);
